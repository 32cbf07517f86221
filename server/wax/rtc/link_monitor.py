"""A viewer's link: when anything last arrived, and the round trip. Pure."""

from __future__ import annotations

from collections import deque
from typing import Final

from wax.bounded_dict import BoundedDict

_WINDOW_S: Final = 10.0
_PONGS: Final = 64


class LinkMonitor:
    """Heartbeat and round trip of one viewer, from their pings.

    Each ping names the last pong received and how long ago, so one exchange gives both ends the
    round trip; the minimum of the last 10 s excludes queueing.
    """

    def __init__(self, now_s: float) -> None:
        self.last_arrival_s = now_s
        self._pongs = BoundedDict[int, float](_PONGS)
        self._round_trips: deque[tuple[float, float]] = deque()
        self.newest_s: float | None = None
        """The newest round trip, with any queueing; None before the first."""

    def record_arrival(self, now_s: float) -> None:
        """Record that something arrived."""
        self.last_arrival_s = max(self.last_arrival_s, now_s)

    def silence_s(self, now_s: float) -> float:
        return now_s - self.last_arrival_s

    def handle_ping(
        self, ping: int, pong: int | None, held_ms: float | None, now_s: float
    ) -> float | None:
        """Handle a ping that is answered now; return the round trip in s if it completes one."""
        round_trip_s = None
        sent_s = self._pongs.get(pong) if pong is not None else None
        if sent_s is not None and held_ms is not None and held_ms >= 0:
            round_trip_s = max(now_s - sent_s - held_ms / 1000, 0.0)
            self._round_trips.append((now_s, round_trip_s))
            self.newest_s = round_trip_s
        while self._round_trips and self._round_trips[0][0] < now_s - _WINDOW_S:
            self._round_trips.popleft()
        self._pongs[ping] = now_s
        return round_trip_s

    @property
    def one_way_s(self) -> float | None:
        """Half the least round trip of the last 10 s, None before the first is known."""
        if not self._round_trips:
            return None
        return min(trip for _, trip in self._round_trips) / 2
