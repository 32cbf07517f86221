"""Packet delay variation of the sound (RFC 5481, 4.2): what a jitter buffer has to bridge."""

from __future__ import annotations

import math
from bisect import bisect_left, insort
from collections import deque
from typing import Final

_MEMORY_S: Final = 20.0
"""How long a delay counts: long enough that 99 of 100 of 50 packets a second are 1,000. Ours.
Half: the same; double: the same."""

_MAX_PACKETS: Final = 4000
"""More are not kept: 20 s of sound are 2,000 at most. A bound of memory."""

_MAX_MS: Final = 10_000.0
"""More is never told; a bound against what cannot be."""


class Jitter:
    """The delays of the last 20 s; told in the order of their sending, `now_s` never falls."""

    def __init__(self) -> None:
        self._told: deque[tuple[float, float]] = deque()
        self._ordered: list[float] = []

    def add(self, delay_s: float, now_s: float) -> None:
        """Count a packet that took `delay_s` between two clocks whose offset is unknown."""
        self._told.append((now_s, delay_s))
        insort(self._ordered, delay_s)
        while self._told[0][0] < now_s - _MEMORY_S or len(self._told) > _MAX_PACKETS:
            self._drop(self._told.popleft()[1])

    def forget_since(self, from_s: float, above_s: float) -> None:
        """Leave out what was told since `from_s` and took longer than `above_s`.

        A queue is answered by sending less, not by a longer buffer.
        """
        kept = []
        while self._told and self._told[-1][0] >= from_s:
            told = self._told.pop()
            if told[1] > above_s:
                self._drop(told[1])
            else:
                kept.append(told)
        self._told.extend(reversed(kept))

    def quantile_ms(self, share: float) -> float:
        """Return within how many ms above the least `share` (0…1) of the packets came."""
        if not self._ordered:
            return 0.0
        last = len(self._ordered) - 1
        at = min(max(int(share * last + 0.5), 0), last) if not math.isnan(share) else last
        return min((self._ordered[at] - self._ordered[0]) * 1000, _MAX_MS)

    def _drop(self, delay_s: float) -> None:
        del self._ordered[bisect_left(self._ordered, delay_s)]
