"""Listens for HTTP or HTTPS connections, and admits a limited number."""

from __future__ import annotations

import asyncio
import socket
import time
from typing import TYPE_CHECKING, Final

from aiohttp import web

from wax.edge.binding import why_not
from wax.edge.turnstile import Turnstile
from wax.errors import StartError
from wax.web.connection import Connection
from wax.web.http_limits import HttpLimits
from wax.web.listening import Listening
from wax.web.senders import limit_key
from wax.web.tls_gate import TlsGate

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from wax.clock import Clock
    from wax.config.server import ServerSettings
    from wax.edge.budget import Payer
    from wax.web.connection_limits import TrackedConnection
    from wax.web.request_budgets import Who
    from wax.web.request_queue import WaitingRequest
    from wax.web.tls import Tls

_SHUTDOWN_S: Final = 0.5
_MADE_S: Final = 0.0002
_HANDSHAKE_S: Final = 0.0015
"""Time charged for accepting a connection, and for its TLS handshake, which asyncio does out of our
sight; nearly all of that is a signature."""


class Entrance:
    """Serves an application; `open` and `close` it. With `tls`, by HTTPS only.

    `who` and `has_people_at` identify known people: see `RequestBudgets`; `asked`: `HttpLimits`.
    """

    def __init__(
        self,
        application: web.Application,
        settings: ServerSettings,
        clock: Clock,
        tls: Tls | None = None,
        *,
        turnstile: Turnstile | None = None,
        who: Who = lambda *_: None,
        has_people_at: Callable[[str], bool] = lambda _: False,
        asked: Collection[str] = (),
    ) -> None:
        self._runner = web.AppRunner(
            application, access_log=None, shutdown_timeout=_SHUTDOWN_S, handle_signals=False
        )
        self._settings = settings
        self._tls = tls
        self._listening: Listening | None = None
        self._making: set[asyncio.Task[object]] = set()
        turnstile = turnstile or Turnstile(clock)
        self.limits = HttpLimits(settings, clock, turnstile, who, has_people_at, asked=asked)

    @property
    def port(self) -> int:
        """The listening port, which the system chose if 0 was configured."""
        assert self._listening is not None, "it is not open"
        return self._listening.port

    async def open(self) -> None:
        """Listen; raises `StartError`."""
        host, port = self._settings.host, self._settings.port
        await self._runner.setup()
        try:
            self._listening = Listening(host, port, self._accept)
        except OSError as error:
            raise StartError(
                f"TCP port {port} of {host} cannot be used: {why_not(error, '--port')}"
            ) from error

    async def close(self) -> None:
        """Stop listening, let requests under way end, and close all connections."""
        if self._listening is not None:
            self._listening.close()
        await self._runner.cleanup()
        self.limits.connections.close_all()
        for task in self._making:
            task.cancel()

    def _accept(self, connection: socket.socket, peer: str) -> None:
        began_s = time.thread_time()
        limits = self.limits
        tracked = limits.enter(peer, connection.close, asyncio.get_running_loop().time())
        if tracked is None:
            limits.log.info("connection refused", why="too many", sender=limit_key(peer))
            connection.close()
            return
        payer, is_urgent = limits.budgets.of_newcomer(tracked.address)
        waiting = limits.queue.enter(
            payer, lambda: self._begin(connection, tracked, peer, payer), urgent=is_urgent
        )
        if waiting is not None:
            tracked.close = lambda: self._give_up(connection, waiting)
        limits.turnstile.charge(payer, began_s)

    def _give_up(self, connection: socket.socket, waiting: WaitingRequest) -> None:
        waiting.cancel()
        connection.close()

    def _begin(
        self, connection: socket.socket, tracked: TrackedConnection, peer: str, payer: Payer
    ) -> None:
        if _has_gone(connection):
            self.limits.connections.leave(tracked)
            connection.close()
            return
        tracked.close = _nothing  # asyncio owns it; `connection_made` checks if it may stay
        cost_s = _MADE_S if self._tls is None else _MADE_S + _HANDSHAKE_S
        self.limits.turnstile.charge(payer, time.thread_time() - cost_s)
        task = asyncio.get_running_loop().create_task(self._make(connection, tracked, peer))
        self._making.add(task)
        task.add_done_callback(self._making.discard)

    async def _make(self, connection: socket.socket, tracked: TrackedConnection, peer: str) -> None:
        loop = asyncio.get_running_loop()
        server = self._runner.server

        def make() -> Connection:
            assert server is not None
            return Connection(self.limits, server, loop, tracked, peer)

        def protocol() -> Connection | TlsGate:
            return make() if self._tls is None else TlsGate(self.limits, self._tls, make, tracked)

        try:
            await loop.connect_accepted_socket(protocol, connection)
        except OSError:  # already closed by its client, or displaced
            self.limits.connections.leave(tracked)
            connection.close()


def _has_gone(connection: socket.socket) -> bool:
    """Whether its client has closed it already: to serve it would cost ten times as much."""
    try:
        return not connection.recv(1, socket.MSG_PEEK)
    except BlockingIOError:
        return False
    except OSError:
        return True


def _nothing() -> None:
    """Close nothing."""
