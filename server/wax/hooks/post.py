"""Post one event: whatever the other end does, it costs four seconds and a few kilobytes."""

from __future__ import annotations

import asyncio
import datetime
import errno
import socket
import threading
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final

import aiohttp
from aiohttp.abc import AbstractResolver, ResolveResult

from wax import __version__
from wax.errors import WaxError
from wax.hooks.signature import headers
from wax.second_look import explained_aside
from wax.sentence import Sentence
from wax.unreachable import Target

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.hooks.outbox import Message

LIMIT_S: Final = 3.0
_LOOK_S: Final = 1.0
"""More, to find out why an event was not taken."""
_BUFFER_BYTES: Final = 2048
_REDIRECTS: Final = range(300, 400)
_WELL: Final = range(200, 300)
_NO_NAME: Final = "no such name can be"
_BAD_REQUEST: Final = 400


class HookError(WaxError):
    """A receiver that does not take an event now, in a sentence for the host."""


def session(own_port: Callable[[], int]) -> aiohttp.ClientSession:
    """Return a session that reaches anything but `own_port` of this machine, and keeps nothing."""

    def socket_to(info: Any) -> socket.socket:
        family, kind, protocol, _, address = info
        if address[1] == own_port() and _is_own(family, address[0]):
            raise OSError(errno.EACCES, "that is this server itself")
        made = socket.socket(family, kind, protocol)
        # aiohttp takes all answers that only announce one (1xx) in one pass: let few come at once.
        made.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER_BYTES)
        return made

    return aiohttp.ClientSession(
        connector=aiohttp.TCPConnector(resolver=_Resolver(), socket_factory=socket_to),
        cookie_jar=aiohttp.DummyCookieJar(),
        headers={"User-Agent": f"WAX/{__version__}", "Content-Type": "application/json"},
        auto_decompress=False,
        read_bufsize=_BUFFER_BYTES,
    )


async def post(
    http: aiohttp.ClientSession,
    url: str,
    message: Message,
    *,
    secret: bytes,
    unix_s: int,
    limit_s: float = LIMIT_S,
    wants_answer: bool = False,
) -> tuple[int, bytes]:
    """Return the status, and how the answer begins where that is wanted; raises `HookError`.

    The answer is not read otherwise, and never beyond what is buffered.
    """
    status, begins = 0, b""
    signed = headers(secret, message.id, unix_s, message.body)
    try:
        async with (
            asyncio.timeout(limit_s),
            http.post(url, data=message.body, headers=signed, allow_redirects=False) as response,
        ):
            status = response.status
            if wants_answer:
                begins = await response.content.read(_BUFFER_BYTES)
    except (aiohttp.ClientError, OSError, ValueError) as error:  # a TimeoutError is an OSError
        if not status:
            raise HookError(await _why(url, error, unix_s, limit_s)) from error
    if status in _REDIRECTS:
        raise HookError(Sentence("hook.redirects", {"status": str(status)}))
    if status == _BAD_REQUEST and url.startswith("http:"):  # so do most that expect TLS answer
        told = await _why(url, ConnectionAbortedError(), unix_s, limit_s)
        if told.code == "unreachable.tls":
            raise HookError(told)
    if status not in _WELL:
        raise HookError(Sentence("hook.answers", {"status": str(status)}))
    return status, begins


async def _why(url: str, error: Exception, unix_s: int, limit_s: float) -> Sentence:
    target = Target.of(url, limit_s)
    assert target is not None, "the configuration takes no other address"
    now = datetime.datetime.fromtimestamp(unix_s, datetime.UTC)
    return await explained_aside(target, error, now, _LOOK_S)


def _is_own(family: int, address: str) -> bool:
    """Whether an address is this machine's: only then can one listen there."""
    with socket.socket(family, socket.SOCK_DGRAM) as tried:
        try:
            tried.bind((address, 0))
        except OSError:
            return False
    return True


class _Resolver(AbstractResolver):
    """Looks names up in threads of its own, of which aiohttp asks for one a name.

    A name server that hangs would take the event loop's few, which the page's files need too, and
    hold up the end of the process.
    """

    async def resolve(
        self, host: str, port: int = 0, family: socket.AddressFamily = socket.AF_UNSPEC
    ) -> list[ResolveResult]:
        loop = asyncio.get_running_loop()
        answered: asyncio.Future[list[Any] | OSError] = loop.create_future()

        def answer(found: list[Any] | OSError) -> None:
            if not answered.done():
                answered.set_result(found)

        def look_up() -> None:
            found: list[Any] | OSError
            try:
                found = socket.getaddrinfo(host, port, family, socket.SOCK_STREAM)
            except OSError as error:
                found = error
            except UnicodeError:  # a label of more than 63 letters
                found = OSError(errno.EINVAL, _NO_NAME)
            with suppress(RuntimeError):  # the server has ended meanwhile
                loop.call_soon_threadsafe(answer, found)

        threading.Thread(target=look_up, name=f"hook {host}", daemon=True).start()
        found = await answered
        if isinstance(found, OSError):
            raise found
        return [
            ResolveResult(
                hostname=host, host=address[0], port=address[1], family=kin, proto=proto, flags=0
            )
            for kin, _, proto, _, address in found
        ]

    async def close(self) -> None:
        """Keep nothing."""
