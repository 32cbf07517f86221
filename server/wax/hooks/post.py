"""Post one event: whatever the receiver does, this takes at most 11 s and a few kilobytes."""

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
"""A name lookup, a handshake and an answer take a few seconds over the slowest links."""
_DIAGNOSIS_S: Final = 1.0
"""Extra time to find out why an attempt failed."""
_BUFFER_BYTES: Final = 2048
_ANSWER_BYTES: Final = 8192
"""No more of an answer is parsed; aiohttp limits one line of its head to about as much."""
_REDIRECTS: Final = range(300, 400)
_WELL: Final = range(200, 300)
_REFUSALS: Final = range(400, 500)
_LATER: Final = (408, 425, 429)
"""Temporary refusals: the same event may be accepted later."""
_WAITED_FOR: Final = (429, 503)
_GONE: Final = 410
_NO_NAME: Final = "such a name cannot exist"
_BAD_REQUEST: Final = 400


class HookError(WaxError):
    """Why a receiver did not accept an event, in a sentence for the host.

    `is_final` if it never will, `is_gone` if it accepts no events any more; `wait_s` is how long
    it asks us to wait.
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
    """Return a session without cookies that reaches anything but `own_port` of this machine."""

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
    """Return the status and, if `wants_answer`, the start of the body; raises `HookError`.

    No more of the body is read than one buffer. `tls` says which authorities to trust, True those
    that this machine trusts.
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
            raise HookError(await explained_aside(target, error, _DIAGNOSIS_S)) from error
    if status in _REDIRECTS:
        raise HookError(Sentence("hook.redirects", {"status": str(status)}))
    if status == _GONE:
        raise HookError(Sentence("hook.gone", {"status": str(status)}), is_gone=True)
    if status == _BAD_REQUEST and url.startswith("http:"):  # most TLS servers answer HTTP so
        told = await explained_aside(target, ConnectionAbortedError(), _DIAGNOSIS_S)
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
    """Return whether an address is this machine's: a socket binds to no other."""
    with socket.socket(family, socket.SOCK_DGRAM) as tried:
        try:
            tried.bind((address, 0))
        except OSError:
            return False
    return True


class _Answer(ResponseHandler):
    """aiohttp's response handler, which parses at most `_ANSWER_BYTES`.

    Without that limit, it parses every interim response (1xx) that has arrived in one pass of the
    event loop, and driving waits for that.
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
    """aiohttp's connector with bounded answers."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self._factory: Any = functools.partial(_Answer, loop=self._loop)


class _Resolver(AbstractResolver):
    """Looks each name up in a thread of its own; aiohttp asks for a name once at a time."""

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
        """Do nothing: no resource is held."""
