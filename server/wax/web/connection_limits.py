"""Limits how many connections are open, and chooses the one that a newcomer displaces. Pure.

A connection is idle, reads a request, or answers one. No address gets more than its share. When
no more may be open, the address with the most loses one: an idle one, else the one that has been
reading for longest, since an honest browser sends a request in one piece, else the one whose
answer takes longest. So an address with few connections keeps them, however slow its link is. The
bytes of unanswered requests are limited in the same way.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    State = Literal["idle", "reading", "answering"]

_ANSWERS_S: Final = 1.0
"""An answer is cut off sooner only for an address that has fewer connections."""
_HELD_BYTES: Final = 8192
"""The mean for as many connections as may be open: an offer has 8 KB, 2 compressed. An address that
holds no more than this, on one connection, keeps it whatever others hold."""


class TrackedConnection:
    """An open connection; `close` is called when another displaces it."""

    __slots__ = ("address", "close", "held_bytes", "since_s", "state")

    def __init__(self, address: str, close: Callable[[], None], now_s: float) -> None:
        self.address = address
        self.close = close
        self.since_s = now_s
        self.state: State = "reading"
        self.held_bytes = 0


class ConnectionLimits:
    """All open connections; each starts as reading."""

    def __init__(self, *, most: int, most_per_address: int) -> None:
        self._most = most
        self._most_per_address = most_per_address
        self._number = 0
        self._most_held_bytes = most * _HELD_BYTES
        self._held_bytes = 0
        self._by_address: dict[str, dict[TrackedConnection, None]] = {}
        """In the order in which their requests began; dictionaries keep it."""
        self.refused = 0
        self.displaced = 0

    def __contains__(self, tracked: TrackedConnection) -> bool:
        return tracked in self._by_address.get(tracked.address, ())

    def __len__(self) -> int:
        return self._number

    def count_of(self, address: str) -> int:
        """Return how many connections an address has."""
        return len(self._by_address.get(address, ()))

    def enter(
        self, address: str, close: Callable[[], None], now_s: float, *, limited: bool
    ) -> TrackedConnection | None:
        """Track a new one; None if there is no room. Only `limited` addresses have a share."""
        own = self._by_address.get(address, ())
        if limited and len(own) >= self._most_per_address:
            has_room = self._displace(own, now_s, least_s=_ANSWERS_S)
        elif self._number >= self._most:
            most = max(self._by_address.values(), key=len)
            has_fewer = len(own) + 1 < len(most)
            has_room = self._displace(most, now_s, least_s=0.0 if has_fewer else _ANSWERS_S)
        else:
            has_room = True
        if not has_room:
            self.refused += 1
            return None
        tracked = TrackedConnection(address, close, now_s)
        self._add(tracked)
        return tracked

    def mark_reading(self, tracked: TrackedConnection, now_s: float) -> None:
        """Note that a request has begun to arrive."""
        tracked.state, tracked.since_s = "reading", now_s
        others = self._by_address.get(tracked.address, {})
        if tracked in others:
            del others[tracked]
            others[tracked] = None

    def mark_answering(self, tracked: TrackedConnection) -> None:
        """Note that the whole request has arrived."""
        tracked.state = "answering"

    def mark_idle(self, tracked: TrackedConnection) -> None:
        """Note that the request was answered, and no other has begun."""
        tracked.state = "idle"

    def set_held_bytes(self, tracked: TrackedConnection, held_bytes: int) -> None:
        """Set how many bytes of unanswered requests a connection holds.

        While the total is too large, the address that holds most loses its largest connection.
        """
        if tracked not in self:
            return
        self._held_bytes += held_bytes - tracked.held_bytes
        tracked.held_bytes = held_bytes
        while self._held_bytes > self._most_held_bytes:
            own = max(self._by_address.values(), key=lambda own: sum(map(_held_bytes, own)))
            self._close(max(own, key=_held_bytes))

    def count_for(
        self, tracked: TrackedConnection, address: str, now_s: float, *, limited: bool
    ) -> bool:
        """Count a proxy's connection as its client's.

        False if the client's `address` has no room.
        """
        if tracked not in self or tracked.address == address:
            return True
        own = self._by_address.get(address, ())
        if (
            limited
            and len(own) >= self._most_per_address
            and not self._displace(own, now_s, least_s=_ANSWERS_S)
        ):
            self.refused += 1
            return False
        self.leave(tracked)
        tracked.address = address
        self._add(tracked)
        return True

    def leave(self, tracked: TrackedConnection) -> None:
        """Stop tracking it; may be called again."""
        if tracked not in self:
            return
        own = self._by_address[tracked.address]
        del own[tracked]
        if not own:
            del self._by_address[tracked.address]
        self._number -= 1
        self._held_bytes -= tracked.held_bytes

    def close_all(self) -> None:
        """Close whatever is still open."""
        for tracked in [one for own in self._by_address.values() for one in own]:
            tracked.close()

    def _displace(
        self, among: Collection[TrackedConnection], now_s: float, *, least_s: float
    ) -> bool:
        """Close one of these; False if all have been answering for less than `least_s`."""
        first: dict[State, TrackedConnection] = {}
        for tracked in among:
            first.setdefault(tracked.state, tracked)
        longest = first.get("idle") or first.get("reading") or first.get("answering")
        if longest is None:
            return False
        if longest.state == "answering" and now_s - longest.since_s < least_s:
            return False
        self._close(longest)
        return True

    def _close(self, tracked: TrackedConnection) -> None:
        self.displaced += 1
        self.leave(tracked)
        tracked.close()

    def _add(self, tracked: TrackedConnection) -> None:
        self._by_address.setdefault(tracked.address, {})[tracked] = None
        self._number += 1
        self._held_bytes += tracked.held_bytes


def _held_bytes(tracked: TrackedConnection) -> int:
    return tracked.held_bytes
