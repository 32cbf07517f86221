"""The built page in memory: everybody's first request, which strangers may repeat at will.

Every file is read, compressed and hashed once. Large files go out in pieces, each once the kernel
has the one before, so that a client that does not read holds no more of them here. Beside sound
and picture on a thin link, files are paced, in pieces that hardly delay the sound.
"""

from __future__ import annotations

import asyncio
import gzip
import hashlib
import mimetypes
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from aiohttp import ETag, hdrs, web

from wax.bounded_dict import BoundedDict
from wax.congestion.wire_cost import MIN_PAYLOAD_BYTES
from wax.errors import NotForUsError
from wax.sentence import Sentence
from wax.web.connection import Connection

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from wax.web.branding import BrandedPage
    from wax.web.opening_calendar import OpeningCalendar

_PIECE_BYTES: Final = 16_384
_PACED_S: Final = 40.0
"""How long a file is paced beside sound and picture; then the rest goes out as fast as it can, so
that the answer hardly ever times out (`wax.web.watch`)."""
_MOST_PAGES: Final = 32
"""Pages that are cached, one for each name of this server, and one more for frames."""
_PACKED: Final = ".gz"
_UNPACKED_TYPE: Final = "application/octet-stream"
_ISOLATED: Final = {"Cross-Origin-Embedder-Policy": "require-corp"}
"""For frames and their workers, which load everything from here. A cross-origin isolated site shows
no frame without it."""
_ANYWHERE: Final = {"Cross-Origin-Resource-Policy": "cross-origin"}
_CALENDAR_TYPE: Final = "text/calendar; charset=utf-8"


@dataclass(frozen=True, slots=True)
class _File:
    content: bytes
    packed: bytes | None
    content_type: str
    digest: str


class BuiltPage:
    """Reads the page in `folder`; raises `OSError` if there is none. `branded` adds branding.

    `calendar` has the opening hours, and is None if the robot is always open.
    """

    def __init__(
        self, folder: Path, branded: BrandedPage, calendar: OpeningCalendar | None = None
    ) -> None:
        self._branded = branded
        self._calendar = calendar
        self._hours: _File | None = None
        self._index = (folder / "index.html").read_text(encoding="utf-8")
        self._pages = BoundedDict[tuple[str, bool], _File](_MOST_PAGES)
        self._files = {
            str(path.relative_to(folder)): _read(path)
            for path in folder.rglob("*")
            if path.is_file() and path.suffix != _PACKED and not path.name.startswith(".")
        }

    async def page(
        self, request: web.Request, origin: str, frame_policy: str | None = None
    ) -> web.StreamResponse:
        """Answer with the page for browsers that know this server by this `origin`.

        With a `frame_policy`, it is the page for frames.
        """
        is_embed = frame_policy is not None
        page = self._pages.get((origin, is_embed)) or _file(
            self._branded.html(self._index, origin, is_embed=is_embed).encode(),
            "text/html; charset=utf-8",
        )
        self._pages[origin, is_embed] = page
        # The assets have a hash in their names; the page itself must be revalidated each time.
        headers = {"Cache-Control": "no-cache"}
        if frame_policy is not None:
            headers |= {"Content-Security-Policy": frame_policy} | _ISOLATED | _ANYWHERE
        return await _send(request, page, headers)

    async def asset(
        self, request: web.Request, path: str, sent: Callable[[int], float | None]
    ) -> web.StreamResponse:
        """Answer with a file of the page; raises `NotForUsError`.

        `sent` counts a piece, in bytes, and returns how many seconds the next must wait; None if
        files are not paced.
        """
        file = self._files.get(path)
        if file is None:
            raise NotForUsError(Sentence("request.no_page"), 404)
        return await _send(request, file, _ISOLATED, sent)

    async def preview(self, request: web.Request) -> web.StreamResponse:
        """Answer with the host's picture for link previews."""
        picture = self._branded.picture
        if picture is None:
            raise web.HTTPNotFound(reason="This page has no picture.")
        file = _File(picture.content, None, picture.content_type, picture.digest)
        return await _send(request, file, cache_headers(request, picture.digest) | _ANYWHERE)

    async def calendar(self, request: web.Request) -> web.StreamResponse:
        """Answer with the opening hours; raises `NotForUsError` if there are none."""
        if self._calendar is None:
            raise NotForUsError(Sentence("request.always_open"), 404)
        content = self._calendar.file()
        if self._hours is None or self._hours.content is not content:
            self._hours = _file(content, _CALENDAR_TYPE)
        return await _send(request, self._hours, {"Cache-Control": "public, max-age=3600"})


def cache_headers(request: web.Request, digest: str) -> dict[str, str]:
    """Return for how long to cache an answer: for good if its URL has the content's digest."""
    if request.query_string == digest:
        return {"Cache-Control": "public, max-age=31536000, immutable"}
    return {"Cache-Control": "public, max-age=3600"}


def _unpaced(_size_bytes: int) -> None: ...


async def _send(
    request: web.Request,
    file: _File,
    headers: dict[str, str],
    sent: Callable[[int], float | None] = _unpaced,
) -> web.StreamResponse:
    headers = {**headers, "Vary": "Accept-Encoding"}
    answer = web.StreamResponse(headers=headers)
    answer.etag = ETag(value=file.digest, is_weak=True)  # weak, since it may be compressed
    # Search the header's text: aiohttp would parse thousands of tags without yielding.
    if f'"{file.digest}"' in request.headers.get(hdrs.IF_NONE_MATCH, ""):
        answer.set_status(304)
        await answer.prepare(request)
        return answer
    content = file.content
    if file.packed is not None and "gzip" in request.headers.get(hdrs.ACCEPT_ENCODING, "").lower():
        content = file.packed
        answer.headers[hdrs.CONTENT_ENCODING] = "gzip"
    answer.headers[hdrs.CONTENT_TYPE] = file.content_type
    answer.content_length = len(content)
    await answer.prepare(request)
    if request.method == hdrs.METH_HEAD:
        return answer
    connection = request.protocol
    whole, loop = memoryview(content), asyncio.get_running_loop()
    until_s = loop.time() + _PACED_S
    while whole:
        is_late = loop.time() >= until_s
        wait_s = sent(_PIECE_BYTES if is_late else MIN_PAYLOAD_BYTES)
        is_paced = wait_s is not None and not is_late
        piece_bytes = MIN_PAYLOAD_BYTES if is_paced else _PIECE_BYTES
        await answer.write(whole[:piece_bytes])
        whole = whole[piece_bytes:]
        if isinstance(connection, Connection):
            await connection.drained()
            if whole and wait_s and is_paced:
                await connection.pause(wait_s)
    return answer


def _read(path: Path) -> _File:
    kind = mimetypes.guess_type(path.name)[0] or _UNPACKED_TYPE
    packed = path.with_name(path.name + _PACKED)
    return _file(path.read_bytes(), kind, packed.read_bytes() if packed.is_file() else None)


def _file(content: bytes, content_type: str, packed: bytes | None = None) -> _File:
    packed = gzip.compress(content, mtime=0) if packed is None else packed
    digest = hashlib.sha256(content).hexdigest()[:16]
    return _File(content, packed, content_type, digest)
