"""Packet delay variation of the sound (RFC 5481, 4.2), which a jitter buffer must bridge."""

from __future__ import annotations

from bisect import bisect_left, insort
from collections import deque
from typing import Final

_MEMORY_S: Final = 8.0
"""How long a delay counts, as in the page's built-in player: 400 packets at 50 a second."""
_MAX_PACKETS: Final = 4000
"""Packets kept at most; 8 s of sound are 800. Bounds the memory."""
_QUANTILE: Final = 0.99
"""Share of the sound that must arrive in time. Ours; NetEq follows 95 to 97 %."""
_MAX_MS: Final = 10_000.0
"""Highest value returned, against invalid feedback."""


class Jitter:
    """The delays of the last 8 s; packets come in the order of sending, `now_s` never falls."""

    def __init__(self) -> None:
        self._delays: deque[tuple[float, float]] = deque()  # time reported, delay
        self._ordered: list[float] = []

    @property
    def ms(self) -> float:
        """The 99th percentile of the delays, in ms above the shortest one."""
        if not self._ordered:
            return 0.0
        at = int(_QUANTILE * (len(self._ordered) - 1) + 0.5)
        return min((self._ordered[at] - self._ordered[0]) * 1000, _MAX_MS)

    def add(self, delay_s: float, now_s: float) -> None:
        """Count a packet that took `delay_s` between two clocks whose offset is unknown."""
        self._delays.append((now_s, delay_s))
        insort(self._ordered, delay_s)
        while self._delays[0][0] < now_s - _MEMORY_S or len(self._delays) > _MAX_PACKETS:
            del self._ordered[bisect_left(self._ordered, self._delays.popleft()[1])]

    def forget_since(self, from_s: float, above_s: float) -> None:
        """Drop the delays reported since `from_s` that are longer than `above_s`.

        The answer to a queue is to send less, not a longer buffer.
        """
        kept = (one for one in self._delays if one[0] < from_s or one[1] <= above_s)
        self._delays = deque(kept)
        self._ordered = sorted(delay_s for _, delay_s in self._delays)
