"""Packet delay variation of the sound (RFC 5481, 4.2), which a jitter buffer must bridge."""

from __future__ import annotations

import math
from bisect import bisect_left, insort
from collections import deque
from typing import Final

_MEMORY_S: Final = 8.0
"""How long a delay counts, as in the page's built-in player: 400 packets at 50 a second. Ours."""
_MAX_PACKETS: Final = 4000
"""Packets kept at most; 8 s of sound are 800. Bounds the memory."""
_MAX_MS: Final = 10_000.0
"""Highest value returned, against invalid feedback."""


class Jitter:
    """The delays of the last 8 s; packets come in the order of sending, `now_s` never falls."""

    def __init__(self) -> None:
        self._delays: deque[tuple[float, float]] = deque()  # time reported, delay
        self._ordered: list[float] = []

    def add(self, delay_s: float, now_s: float) -> None:
        """Count a packet that took `delay_s` between two clocks whose offset is unknown."""
        self._delays.append((now_s, delay_s))
        insort(self._ordered, delay_s)
        while self._delays[0][0] < now_s - _MEMORY_S or len(self._delays) > _MAX_PACKETS:
            self._drop(self._delays.popleft()[1])

    def forget_since(self, from_s: float, above_s: float) -> None:
        """Drop the delays reported since `from_s` that are longer than `above_s`.

        The answer to a queue is to send less, not a longer buffer.
        """
        kept = []
        while self._delays and self._delays[-1][0] >= from_s:
            reported = self._delays.pop()
            if reported[1] > above_s:
                self._drop(reported[1])
            else:
                kept.append(reported)
        self._delays.extend(reversed(kept))

    def quantile_ms(self, share: float) -> float:
        """Return the quantile `share` (0…1) of the delays, in ms above the shortest one."""
        if not self._ordered:
            return 0.0
        last = len(self._ordered) - 1
        at = min(max(int(share * last + 0.5), 0), last) if not math.isnan(share) else last
        return min((self._ordered[at] - self._ordered[0]) * 1000, _MAX_MS)

    def _drop(self, delay_s: float) -> None:
        del self._ordered[bisect_left(self._ordered, delay_s)]
