"""Where connections come in: listens, by HTTP or HTTPS, and lets in only so many."""

from __future__ import annotations

import asyncio
import errno
import time
from typing import TYPE_CHECKING, Final

import structlog
from aiohttp import web

from wax.edge.turnstile import Turnstile
from wax.errors import StartError
from wax.web.accounts import Accounts
from wax.web.connection import Connection
from wax.web.connection_limits import ConnectionLimits
from wax.web.line import Line
from wax.web.listening import Listening
from wax.web.senders import Proxies, limited
from wax.web.sparse_log import SparseLog
from wax.web.tls_gate import TlsGate

if TYPE_CHECKING:
    import socket
    from collections.abc import Callable

    from wax.access.access import Shown
    from wax.clock import Clock
    from wax.config.settings import ServerSettings
    from wax.edge.budget import Payer
    from wax.web.connection_limits import Place
    from wax.web.line import Waiting
    from wax.web.tls import Tls

_LOG = structlog.get_logger(__name__)

_SHUTDOWN_S: Final = 0.5
_MADE_S: Final = 0.0002
_HANDSHAKE_S: Final = 0.0015
"""What a connection costs until it can say something, and TLS: nearly all of that is a signature,
made in the middle of asyncio's own work."""


class Entrance:
    """Serves an application; `open` and `close` it. With `tls`, by HTTPS only.

    `who` tells who is known: see `Accounts`.
    """

    def __init__(
        self,
        application: web.Application,
        settings: ServerSettings,
        clock: Clock,
        tls: Tls | None = None,
        *,
        turnstile: Turnstile | None = None,
        who: Callable[[Shown, str], str | None] = lambda *_: None,
    ) -> None:
        self._runner = web.AppRunner(
            application, access_log=None, shutdown_timeout=_SHUTDOWN_S, handle_signals=False
        )
        self._settings = settings
        self.proxies = Proxies(settings.trusted_proxies)
        self._tls = tls
        self._clock = clock
        self._listening: Listening | None = None
        self._making: set[asyncio.Task[object]] = set()
        self.turnstile = turnstile or Turnstile(clock)
        self.accounts = Accounts(self.turnstile, who)
        self.line = Line(self.turnstile)
        self._cut = 0
        self.log = SparseLog(_LOG, clock)
        self.limits = ConnectionLimits(
            most=settings.max_connections, most_per_address=settings.max_connections_per_address
        )

    @property
    def port(self) -> int:
        """The port that is listened on, which the system chose if 0 was asked for."""
        assert self._listening is not None, "it is not open"
        return self._listening.port

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
        try:
            self._listening = Listening(host, port, self._accept)
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
        for task in self._making:
            task.cancel()

    def counted(self, peer: str) -> str:
        """Return what limits count a connection's other end as."""
        return limited(peer)

    def is_for(self, place: Place, address: str) -> bool:
        """Count a connection for the address that asks through it; False if it has no room."""
        is_limited = not self.proxies.trusts(address)
        return self.limits.is_for(place, address, self._now_s(), limited=is_limited)

    def _accept(self, connection: socket.socket, peer: str) -> None:
        began_s = time.thread_time()
        address = limited(peer)
        place = self.limits.enter(
            address, connection.close, self._now_s(), limited=not self.proxies.trusts(peer)
        )
        if place is None:
            self.log.info("connection refused", why="too many", sender=address)
            connection.close()
            return
        payer = self.accounts.of_guest(address)
        waiting = self.line.enter(payer, lambda: self._begin(connection, place, peer, payer))
        if waiting is not None:
            place.close = lambda: self._give_up(connection, waiting)
        self.turnstile.charge(payer, began_s)

    def _give_up(self, connection: socket.socket, waiting: Waiting) -> None:
        waiting.leave()
        connection.close()

    def _begin(self, connection: socket.socket, place: Place, peer: str, payer: Payer) -> None:
        place.close = _nothing  # asyncio has it; what it makes of it looks at its place first
        cost_s = _MADE_S if self._tls is None else _MADE_S + _HANDSHAKE_S
        self.turnstile.charge(payer, time.thread_time() - cost_s)
        task = asyncio.get_running_loop().create_task(self._make(connection, place, peer))
        self._making.add(task)
        task.add_done_callback(self._making.discard)

    async def _make(self, connection: socket.socket, place: Place, peer: str) -> None:
        loop = asyncio.get_running_loop()
        server = self._runner.server

        def make() -> Connection:
            assert server is not None
            return Connection(self, server, loop, place, peer)

        def protocol() -> Connection | TlsGate:
            return make() if self._tls is None else TlsGate(self, self._tls, make, place)

        try:
            await loop.connect_accepted_socket(protocol, connection)
        except OSError:  # it has gone, or made room, already
            self.limits.leave(place)
            connection.close()

    def _now_s(self) -> float:
        return asyncio.get_running_loop().time()

    def cut(self, why: str) -> None:
        """Count a connection that was closed because of what its client did, or did not."""
        self._cut += 1
        self.log.info("connection closed", why=why)


def _nothing() -> None:
    """Close nothing."""
