"""How much single packets of sound are late, which is what a jitter buffer has to bridge."""

from __future__ import annotations

import math
from bisect import bisect_left, insort
from collections import deque
from typing import Final

_MEMORY_S: Final = 20.0
_MOST: Final = 4000
_MOST_MS: Final = 10_000.0


class Jitter:
    """The ways of the last 20 s; told in the order of their sending, `now_s` never falls."""

    def __init__(self) -> None:
        self._told: deque[tuple[float, float]] = deque()
        self._ordered: list[float] = []

    def add(self, way_s: float, now_s: float) -> None:
        """Count a packet that took `way_s` between two clocks whose offset is unknown."""
        self._told.append((now_s, way_s))
        insort(self._ordered, way_s)
        while self._told[0][0] < now_s - _MEMORY_S or len(self._told) > _MOST:
            self._drop(self._told.popleft()[1])

    def forget_since(self, from_s: float, above_s: float) -> None:
        """Leave out what was told since `from_s` and took longer than `above_s`.

        A queue is answered by sending less, not by waiting longer.
        """
        kept = []
        while self._told and self._told[-1][0] >= from_s:
            told = self._told.pop()
            if told[1] > above_s:
                self._drop(told[1])
            else:
                kept.append(told)
        self._told.extend(reversed(kept))

    def forget(self) -> None:
        self._told.clear()
        self._ordered.clear()

    def quantile_ms(self, share: float) -> float:
        """Return within how many ms above the least `share` (0…1) of the packets came."""
        if not self._ordered:
            return 0.0
        last = len(self._ordered) - 1
        at = min(max(int(share * last + 0.5), 0), last) if not math.isnan(share) else last
        return min((self._ordered[at] - self._ordered[0]) * 1000, _MOST_MS)

    def _drop(self, way_s: float) -> None:
        del self._ordered[bisect_left(self._ordered, way_s)]
