"""Post one event: whatever the other end does, it costs 11 s and a few kilobytes."""

from __future__ import annotations

import asyncio
import errno
import functools
import socket
from typing import TYPE_CHECKING, Any, Final

import aiohttp
from aiohttp.abc import AbstractResolver, ResolveResult
from aiohttp.client_proto import ResponseHandler

from wax import __version__
from wax.as_written import as_written
from wax.daemon_call import daemon_call
from wax.errors import WaxError
from wax.hooks.retry_after import wait_s
from wax.hooks.signature import headers
from wax.second_look import explained_aside
from wax.sentence import Sentence
from wax.unreachable import Target

if TYPE_CHECKING:
    import ssl
    from collections.abc import Callable

    from wax.hooks.outbox import Message

LIMIT_S: Final = 10.0
"""A name, a handshake and an answer over the slowest links take a few seconds."""
_LOOK_S: Final = 1.0
"""More, to find out why an event was not taken."""
_BUFFER_BYTES: Final = 2048
_ANSWER_BYTES: Final = 8192
"""An answer is parsed no further: its head is one that aiohttp would take, too."""
_REDIRECTS: Final = range(300, 400)
_WELL: Final = range(200, 300)
_REFUSALS: Final = range(400, 500)
_LATER: Final = (408, 425, 429)
"""Of the refusals, those of now: the same event may be taken later."""
_WAITED_FOR: Final = (429, 503)
_GONE: Final = 410
_NO_NAME: Final = "no such name can be"
_BAD_REQUEST: Final = 400


class HookError(WaxError):
    """A receiver that does not take an event, in a sentence for the host.

    `is_final` if it never will, `is_gone` if it takes no event any more; `wait_s` is how long it
    asks us to wait.
    """

    def __init__(
        self,
        sentence: Sentence,
        *,
        is_final: bool = False,
        is_gone: bool = False,
        wait_s: float = 0.0,
    ) -> None:
        super().__init__(sentence)
        self.is_final = is_final
        self.is_gone = is_gone
        self.wait_s = wait_s


def session(own_port: Callable[[], int]) -> aiohttp.ClientSession:
    """Return a session that reaches anything but `own_port` of this machine, and keeps nothing."""

    def socket_to(info: Any) -> socket.socket:
        family, kind, protocol, _, address = info
        if address[1] == own_port() and _is_own(family, address[0]):
            raise OSError(errno.EACCES, "that is this server itself")
        return socket.socket(family, kind, protocol)

    return aiohttp.ClientSession(
        connector=_Connector(resolver=_Resolver(), socket_factory=socket_to),
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
    tls: ssl.SSLContext | bool = True,
    limit_s: float = LIMIT_S,
    wants_answer: bool = False,
) -> tuple[int, bytes]:
    """Return the status, and how the answer begins where that is wanted; raises `HookError`.

    The answer is not read otherwise, and never beyond what is buffered. `tls` is whom to trust,
    True for whom this machine trusts.
    """
    target = Target.of(url, limit_s, ca_key="[[hook]] ca_file", has_ca=tls is not True)
    assert target is not None, "the configuration takes no other address"
    status, begins, asked_s = 0, b"", 0.0
    signed = headers(secret, message.id, unix_s, message.body)
    try:
        async with (
            asyncio.timeout(limit_s),
            http.post(
                as_written(url),
                data=message.body,
                headers=signed,
                allow_redirects=False,
                ssl=tls,
            ) as response,
        ):
            status = response.status
            if status in _WAITED_FOR:
                asked_s = wait_s(response.headers.get("Retry-After"), unix_s)
            if wants_answer:
                begins = await response.content.read(_BUFFER_BYTES)
    except (aiohttp.ClientError, OSError, ValueError) as error:  # a TimeoutError is an OSError
        if not status:
            raise HookError(await explained_aside(target, error, _LOOK_S)) from error
    if status in _REDIRECTS:
        raise HookError(Sentence("hook.redirects", {"status": str(status)}))
    if status == _GONE:
        raise HookError(Sentence("hook.gone", {"status": str(status)}), is_gone=True)
    if status == _BAD_REQUEST and url.startswith("http:"):  # so do most that expect TLS answer
        told = await explained_aside(target, ConnectionAbortedError(), _LOOK_S)
        if told.code == "unreachable.tls":
            raise HookError(told)
    if status not in _WELL:
        raise HookError(
            Sentence("hook.answers", {"status": str(status)}),
            is_final=status in _REFUSALS and status not in _LATER,
            wait_s=asked_s,
        )
    return status, begins


def _is_own(family: int, address: str) -> bool:
    """Whether an address is this machine's: only then can one listen there."""
    with socket.socket(family, socket.SOCK_DGRAM) as tried:
        try:
            tried.bind((address, 0))
        except OSError:
            return False
    return True


class _Answer(ResponseHandler):
    """aiohttp's, which parses so many bytes at most.

    By itself it takes all answers that only announce one (1xx) in one pass of the event loop, as
    many as have come, and driving waits for that.
    """

    _left = _ANSWER_BYTES

    def set_response_params(self, **params: Any) -> None:
        self._left = _ANSWER_BYTES
        super().set_response_params(**params)

    def data_received(self, data: bytes) -> None:
        taken, self._left = data[: self._left], self._left - len(data)
        if taken:
            super().data_received(taken)
        if self._left < 0:
            self._left = 0
            if self.transport is not None:
                self.transport.pause_reading()


class _Connector(aiohttp.TCPConnector):
    """Whose answers are bounded."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self._factory: Any = functools.partial(_Answer, loop=self._loop)


class _Resolver(AbstractResolver):
    """Looks names up in threads of its own, of which aiohttp asks for one a name."""

    async def resolve(
        self, host: str, port: int = 0, family: socket.AddressFamily = socket.AF_UNSPEC
    ) -> list[ResolveResult]:
        def look_up() -> list[Any]:
            try:
                return socket.getaddrinfo(host, port, family, socket.SOCK_STREAM)
            except UnicodeError:  # a label of more than 63 letters
                raise OSError(errno.EINVAL, _NO_NAME) from None

        found = await daemon_call(f"hook {host}", look_up)
        return [
            ResolveResult(
                hostname=host, host=address[0], port=address[1], family=kin, proto=proto, flags=0
            )
            for kin, _, proto, _, address in found
        ]

    async def close(self) -> None:
        """Keep nothing."""
