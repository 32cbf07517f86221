"""Where connections come in: listens, by HTTP or HTTPS, and lets in only so many."""

from __future__ import annotations

import asyncio
import errno
from typing import TYPE_CHECKING, Final

import structlog
from aiohttp import web

from wax.errors import StartError
from wax.web.connection import Connection
from wax.web.connection_limits import ConnectionLimits
from wax.web.senders import Proxies, limited
from wax.web.sparse_log import SparseLog
from wax.web.tls_gate import TlsGate

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config.settings import ServerSettings
    from wax.web.connection_limits import Place
    from wax.web.tls import Tls

_LOG = structlog.get_logger(__name__)

_SHUTDOWN_S: Final = 0.5
_BACKLOG: Final = 64
"""asyncio accepts as many in one pass of the event loop, which the control loop waits for."""


class Entrance:
    """Serves an application; `open` and `close` it. With `tls`, by HTTPS only."""

    def __init__(
        self,
        application: web.Application,
        settings: ServerSettings,
        clock: Clock,
        tls: Tls | None = None,
    ) -> None:
        self._runner = web.AppRunner(
            application, access_log=None, shutdown_timeout=_SHUTDOWN_S, handle_signals=False
        )
        self._settings = settings
        self._proxies = Proxies(settings.trusted_proxies)
        self._tls = tls
        self._listening: asyncio.Server | None = None
        self._cut = 0
        self.log = SparseLog(_LOG, clock)
        self.limits = ConnectionLimits(
            most=settings.max_connections, most_per_address=settings.max_connections_per_address
        )

    @property
    def port(self) -> int:
        """The port that is listened on, which the system chose if 0 was asked for."""
        assert self._listening is not None, "it is not open"
        return int(self._listening.sockets[0].getsockname()[1])

    def status(self) -> dict[str, int]:
        """Return counts for the status page."""
        return {
            "open": len(self.limits),
            "refused": self.limits.refused,
            "displaced": self.limits.displaced,
            "cut": self._cut,
        }

    async def open(self) -> None:
        """Listen; raises `StartError`."""
        host, port = self._settings.host, self._settings.port
        await self._runner.setup()
        server = self._runner.server
        assert server is not None
        loop = asyncio.get_running_loop()

        def connection() -> Connection | TlsGate:
            if self._tls is None:
                return Connection(self, server, loop)
            return TlsGate(self, self._tls, lambda place: Connection(self, server, loop, place))

        try:
            self._listening = await loop.create_server(connection, host, port, backlog=_BACKLOG)
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                raise StartError(
                    f"port {port} is used by another program; end it, or choose another port"
                    " with --port"
                ) from error
            raise StartError(
                f"cannot listen on {host}:{port}: {error.strerror or error};"
                " check --host and --port"
            ) from error

    async def close(self) -> None:
        """Stop listening, let requests under way end, and close all connections."""
        if self._listening is not None:
            self._listening.close()
        await self._runner.cleanup()
        self.limits.close_all()

    def enter(self, transport: asyncio.Transport) -> Place | None:
        """Return a place for a new connection; None if it is to be closed."""
        peer = transport.get_extra_info("peername") or ("",)
        place = self.limits.enter(
            limited(peer[0]), transport.abort, limited=not self._proxies.trusts(peer[0])
        )
        if place is None:
            self.log.info("connection refused", why="too many", sender=limited(peer[0]))
        return place

    def cut(self, why: str) -> None:
        """Count a connection that was closed because of what its client did, or did not."""
        self._cut += 1
        self.log.info("connection closed", why=why)
