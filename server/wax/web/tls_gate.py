"""TLS handshakes: their connections count from the start, and have a timeout.

asyncio's own servers report a TLS connection only after its handshake, so those that never shake
hands would not count. And here, each connection gets the newest certificate. After the handshake,
the time that TLS takes counts as the connection's work: reading 2 KB of key updates (RFC 8446,
4.6.3) takes 2 ms.
"""

from __future__ import annotations

import asyncio
import ssl
from asyncio import sslproto
from functools import partial
from typing import TYPE_CHECKING, Any, Final, cast

from wax.machine.memory import break_circle
from wax.web.watch import READ_S

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.web.connection import Connection
    from wax.web.connection_limits import TrackedConnection
    from wax.web.http_limits import HttpLimits
    from wax.web.tls import Tls

_CLOSE_S: Final = 2.0


class _MeteredTls(sslproto.SSLProtocol):
    def buffer_updated(self, nbytes: int) -> None:
        connection = cast("Connection", self._app_protocol)
        connection.read_by_tls(partial(super().buffer_updated, nbytes))


class _Secured(sslproto._SSLProtocolTransport):
    """Pauses the TCP transport itself; asyncio would go on reading, and buffer up to 256 KiB."""

    def pause_reading(self) -> None:
        cast("Any", self._ssl_protocol)._transport.pause_reading()

    def resume_reading(self) -> None:
        cast("Any", self._ssl_protocol)._transport.resume_reading()


class TlsGate(asyncio.Protocol):
    """Does the handshake, then hands over to a new `Connection`."""

    def __init__(
        self,
        limits: HttpLimits,
        tls: Tls,
        make: Callable[[], Connection],
        tracked: TrackedConnection,
    ) -> None:
        self._limits = limits
        self._tls = tls
        self._make = make
        self._tracked = tracked
        self._early = bytearray()
        self._lost = False
        self._task: asyncio.Task[None] | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        tcp = cast("asyncio.Transport", transport)
        if self._tracked not in self._limits.connections:  # already displaced
            tcp.abort()
            break_circle(tcp)
            return
        self._tracked.close = tcp.abort
        # The handshake must not be read before TLS is set up.
        tcp.pause_reading()
        self._task = asyncio.create_task(self._shake_hands(tcp))

    def data_received(self, data: bytes) -> None:
        """Buffer what arrives with the end of the handshake."""
        self._early += data

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: ARG002  # asyncio's form
        self._lost = True

    async def _shake_hands(self, tcp: asyncio.Transport) -> None:
        handed_over = False
        try:
            secured = await asyncio.get_running_loop().start_tls(
                tcp,
                self,
                self._tls.context(),
                server_side=True,
                ssl_handshake_timeout=READ_S,
                ssl_shutdown_timeout=_CLOSE_S,
            )
            if secured is None or self._lost:
                return
            connection = self._make()
            tls: Any = tcp.get_protocol()
            tls.__class__, secured.__class__ = _MeteredTls, _Secured
            connection.connection_made(secured)
            connection.tcp_transport = tcp
            secured.set_protocol(connection)
            handed_over = True
            if self._early:
                connection.data_received(bytes(self._early))
        except (OSError, ssl.SSLError):
            self._limits.count_cut("no TLS handshake")
        finally:
            if not handed_over:
                tcp.abort()
                break_circle(tcp)
                self._limits.connections.leave(self._tracked)
