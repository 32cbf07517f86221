"""What all HTTP connections share: their number, their budgets, and the queue of requests."""

from __future__ import annotations

import asyncio
from collections import deque
from typing import TYPE_CHECKING, Final

import structlog

from wax.web.connection_limits import ConnectionLimits
from wax.web.request_budgets import RequestBudgets
from wax.web.request_queue import RequestQueue
from wax.web.senders import Proxies, limit_key
from wax.web.sparse_log import SparseLog

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from wax.clock import Clock
    from wax.config.server import ServerSettings
    from wax.edge.turnstile import Turnstile
    from wax.web.connection_limits import TrackedConnection
    from wax.web.request_budgets import Who

_END_IN_A_PASS: Final = 4

_LOG = structlog.get_logger(__name__)


class HttpLimits:
    """Made by the `Entrance`; for `who` and `has_people_at` see `RequestBudgets`.

    `asked` are the headers by which a trusted proxy says who somebody is.
    """

    def __init__(
        self,
        settings: ServerSettings,
        clock: Clock,
        turnstile: Turnstile,
        who: Who = lambda *_: None,
        has_people_at: Callable[[str], bool] = lambda _: False,
        *,
        asked: Collection[str] = (),
    ) -> None:
        self.asked = asked
        self.turnstile = turnstile
        self.budgets = RequestBudgets(turnstile, who, has_people_at)
        self.queue = RequestQueue(turnstile)
        self.proxies = Proxies(settings.trusted_proxies)
        self.connections = ConnectionLimits(
            most=settings.max_connections, most_per_address=settings.max_connections_per_address
        )
        self.log = SparseLog(_LOG, clock)
        self._ending: deque[Callable[[], None]] = deque()
        self._cut = 0

    def status(self) -> dict[str, int]:
        """Return counts for the status page."""
        return {
            "open": len(self.connections),
            "refused": self.connections.refused,
            "displaced": self.connections.displaced,
            "cut": self._cut,
        }

    def enter(self, peer: str, close: Callable[[], None], now_s: float) -> TrackedConnection | None:
        """Track a connection from `peer`; None if it has to be refused."""
        is_limited = not self.proxies.trusts(peer)
        return self.connections.enter(limit_key(peer), close, now_s, limited=is_limited)

    def count_for(self, tracked: TrackedConnection, address: str, now_s: float) -> bool:
        """Count a proxy's connection as its client's; False if the client's has no room."""
        is_limited = not self.proxies.trusts(address)
        return self.connections.count_for(tracked, address, now_s, limited=is_limited)

    def end_soon(self, abort: Callable[[], None]) -> None:
        """End a connection soon: of many that time out together, a few end in each pass."""
        self._ending.append(abort)
        if len(self._ending) == 1:
            asyncio.get_running_loop().call_soon(self._end_some)

    def _end_some(self) -> None:
        some = [self._ending.popleft() for _ in range(min(_END_IN_A_PASS, len(self._ending)))]
        if self._ending:
            asyncio.get_running_loop().call_soon(self._end_some)
        for abort in some:
            abort()

    def count_cut(self, why: str) -> None:
        """Count a connection that was closed for what its client did, or failed to do."""
        self._cut += 1
        self.log.info("connection closed", why=why)
