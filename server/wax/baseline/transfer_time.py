"""Measures the transfer time T_r, and tracks the one MU of a stream in flight.

In 2004 the client pulled over TCP, so "sent" meant received (thesis 3.2). Here an MU counts as
sent when the page has acknowledged its last packet; nothing newer of its stream is sent before.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from wax.baseline.media_units import MediaUnit

_NEWEST: Final = 3
"""T_r is the median of this many: one late picture is jitter (5.2.1.1), two of three are due to the
link. The thesis measures V_2 alone, and so do we at start-up."""

_LEAST_PATIENCE_S: Final = 1.0
"""The shortest wait before an MU counts as lost, like TCP's shortest timer (RFC 6298, 2.4)."""


@dataclass(frozen=True, slots=True)
class UnitUnderWay:
    """An MU that has left and is not yet acknowledged."""

    mu: MediaUnit
    left_s: float


class LeastRoundTrip:
    """The shortest round trip seen, 0 before any."""

    def __init__(self) -> None:
        self._least_s: float | None = None

    @property
    def seconds(self) -> float:
        return self._least_s or 0.0

    def seen(self, round_trip_s: float) -> None:
        """Count a measurement; one that is not above 0 is ignored as invalid."""
        if round_trip_s > 0 and (self._least_s is None or round_trip_s < self._least_s):
            self._least_s = round_trip_s


class TransferTime:
    """T_r of one stream: first packet to acknowledgement, less the shortest round trip seen."""

    def __init__(self, round_trip: LeastRoundTrip, *, lost_after_s: float) -> None:
        self._round_trip = round_trip
        self._lost_after_s = lost_after_s
        self._newest_s: deque[float] = deque(maxlen=_NEWEST)
        self.under_way: UnitUnderWay | None = None
        self.last_interval_s: float | None = None
        """How long the last MU delayed the next, round trip included."""

    @property
    def seconds(self) -> float | None:
        """T_r, None before the first measurement."""
        return median(self._newest_s) if self._newest_s else None

    def at_least_s(self, now_s: float) -> float | None:
        """Return T_r, or more if the MU in flight already takes longer."""
        if self.under_way is None:
            return self.seconds
        so_far_s = self._less_round_trip(now_s - self.under_way.left_s)
        if not self._newest_s:
            return so_far_s
        if_it_ended_now_s = median([*self._newest_s, so_far_s][-_NEWEST:])
        return max(median(self._newest_s), if_it_ended_now_s)

    def left(self, mu: MediaUnit, now_s: float) -> None:
        """Record that an MU is sent; the last one must have been acknowledged or given up."""
        if self.under_way is not None:
            raise RuntimeError(f"{self.under_way.mu} is still in flight; acknowledge it first")
        self.under_way = UnitUnderWay(mu, now_s)

    def acknowledged(self, number: int, now_s: float) -> MediaUnit | None:
        """Record an acknowledgement; return its MU, None if it is not the one in flight."""
        if self.under_way is None or self.under_way.mu.number != number:
            return None
        return self._done(now_s)

    def give_up_s(self) -> float | None:
        """Return when the MU in flight will count as lost, None without one."""
        if self.under_way is None:
            return None
        patience_s = self._lost_after_s
        if self._newest_s:
            # TCP's rule of thumb for an overdue reply, within fixed bounds.
            expected_s = 4 * median(self._newest_s) + 2 * self._round_trip.seconds
            patience_s = min(max(expected_s, _LEAST_PATIENCE_S), self._lost_after_s)
        return self.under_way.left_s + patience_s

    def give_up(self, now_s: float) -> MediaUnit | None:
        """Give up the MU in flight if it counts as lost; the wait then counts as its T_r."""
        give_up_s = self.give_up_s()
        return self._done(now_s) if give_up_s is not None and now_s >= give_up_s else None

    def forget(self) -> None:
        """Restart the measurement, as at start-up; the MU in flight stays in flight."""
        self._newest_s.clear()
        self.last_interval_s = None

    def _done(self, now_s: float) -> MediaUnit | None:
        done, self.under_way = self.under_way, None
        if done is None:
            return None
        self.last_interval_s = now_s - done.left_s
        self._newest_s.append(self._less_round_trip(self.last_interval_s))
        return done.mu

    def _less_round_trip(self, interval_s: float) -> float:
        return max(0.0, interval_s - self._round_trip.seconds)
