"""How long packets wait in the way, from times of two clocks that were never set alike.

The difference of arrival and sending holds the clocks' unknown offset; what it is above the least
of the last half minute is waiting. So a drift of the clocks (100 ppm are 3 ms in that time) and
a new route are forgotten.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final

_MEMORY_S: Final = 30.0
_BUCKET_S: Final = 0.5
_RECENT_S: Final = 0.07
_RECENT_PACKETS: Final = 3
_SMALL_BYTES: Final = 100
_TYPICAL_GAIN: Final = 0.01
_MOST_TYPICAL_S: Final = 0.015
_ROUGH_GAIN: Final = 0.1
_FIRST_ROUGH_S: Final = 0.002


class QueuingDelay:
    """Times in seconds; told of every packet that arrived, in the order of their sending."""

    def __init__(self) -> None:
        self._least: deque[tuple[float, float]] = deque()  # rising, from buckets of time
        self._recent: deque[tuple[float, float]] = deque()
        self._before_s: float | None = None
        self._rough = _FIRST_ROUGH_S**2
        self._typical_s = 0.0

    @property
    def least_s(self) -> float:
        """The least difference of arrival and sending; of nothing it is infinite."""
        return self._least[0][1] if self._least else math.inf

    @property
    def rough_s(self) -> float:
        """How much the way differs from one packet to the next (root of the mean square)."""
        return math.sqrt(self._rough)

    @property
    def standing_s(self) -> float:
        """How long everything that came lately had to wait at least, beyond what is usual.

        The least of several: one packet that is late is none, and of those that a stall held and
        let go together the last has not waited.
        """
        return max(0.0, self._shortest_s() - self._typical_s)

    @property
    def span_s(self) -> float:
        """The time over which came what `standing_s` is about."""
        return self._recent[-1][0] - self._recent[0][0] if self._recent else 0.0

    def add(self, sent_s: float, arrived_s: float, size_bytes: int, rate_bps: float) -> float:
        """Return how long this one waited; its own length at the rate is not waiting."""
        way_s = arrived_s - sent_s
        self._follow(sent_s, way_s)
        if self._before_s is not None:
            # One stall is not to make the way look rough for long.
            step = min(abs(way_s - self._before_s), 3 * self.rough_s + 0.001)
            self._rough += _ROUGH_GAIN * (step * step - self._rough)
        self._before_s = way_s
        own_s = max(0, size_bytes - _SMALL_BYTES) * 8 / rate_bps
        waited_s = max(0.0, way_s - self.least_s - own_s)
        self._recent.append((arrived_s, waited_s))
        while len(self._recent) > _RECENT_PACKETS and (
            self._recent[0][0] < arrived_s - _RECENT_S or self._recent[0][0] > arrived_s
        ):
            self._recent.popleft()
        return max(0.0, way_s - self.least_s)

    def settle(self) -> None:
        """Take what everything waits now for usual, slowly; for a link that is not congested."""
        self._typical_s += _TYPICAL_GAIN * (self._shortest_s() - self._typical_s)
        self._typical_s = min(self._typical_s, _MOST_TYPICAL_S)

    def relearn(self) -> None:
        """Forget the least that was known: the way has become longer."""
        self._least.clear()
        self._recent.clear()
        self._before_s = None

    def _shortest_s(self) -> float:
        return min((waited_s for _, waited_s in self._recent), default=0.0)

    def _follow(self, sent_s: float, way_s: float) -> None:
        while self._least and self._least[0][0] < sent_s - _MEMORY_S:
            self._least.popleft()
        if self._least and way_s >= self._least[-1][1] and sent_s < self._least[-1][0] + _BUCKET_S:
            return
        while self._least and self._least[-1][1] >= way_s:
            self._least.pop()
        self._least.append((sent_s, way_s))
