"""The delivery rate of a busy link: a queue that never empties drains at the link's capacity.

The delivery rate sample of draft-cheng-iccrg-delivery-rate-estimation, taken over busy periods
only, so that the application never limits it.
"""

from __future__ import annotations

import math
from collections import deque
from itertools import pairwise
from typing import Final

_WINDOW_S: Final = 0.8
"""Measured over at most this much of a busy period. GCC: 0.5 to 1 s (T in 5.6)."""
_MIN_BUSY_S: Final = 0.06
"""Minimum busy period: the arrivals within one feedback packet have jitter. Ours."""
_MIN_PACKETS: Final = 3
"""Minimum packets: without the longest gap, three leave one gap. Ours."""
_MAX_PACKETS: Final = 512
"""Packets kept at most: the window at 640 a second. Bounds the work where a page's clock stands."""
_BACK_TO_BACK_S: Final = 0.005
"""How much later than this packet would have come alone the one before must arrive, for both to
count as queued. As GCC's burst_time (5.6)."""


class DeliveryRate:
    """Takes every packet that arrived, in the order of sending; times in seconds."""

    def __init__(self) -> None:
        self._busy: deque[tuple[float, float]] = deque(maxlen=_MAX_PACKETS)
        """Arrival, and the bytes that came until then."""
        self._bytes = 0.0
        self._arrived_s = -math.inf

    def add(self, unqueued_s: float, arrived_s: float, size_bytes: float) -> None:
        """Count `size_bytes` that arrived by `arrived_s`.

        `unqueued_s` is when the packet would have arrived without a queue. If the packet before
        arrived no earlier than that, both left the queue back to back.
        """
        if not self._arrived_s > unqueued_s + _BACK_TO_BACK_S or arrived_s < self._arrived_s:
            self.clear()
        self._bytes += size_bytes
        self._arrived_s = arrived_s
        self._busy.append((arrived_s, self._bytes))
        while len(self._busy) > 2 and self._busy[1][0] < arrived_s - _WINDOW_S:
            self._busy.popleft()

    def rate_bps(self) -> float | None:
        """Return the rate of the current busy period; None if it is too short."""
        if len(self._busy) < _MIN_PACKETS:
            return None
        gaps = [(b - a, later - total) for (a, total), (b, later) in pairwise(self._busy)]
        # A stall pauses the link, but does not change its rate.
        longest = max(gaps)
        took_s = sum(gap_s for gap_s, _ in gaps) - longest[0]
        size_bytes = sum(size for _, size in gaps) - longest[1]
        return size_bytes * 8 / took_s if took_s >= _MIN_BUSY_S else None

    def clear(self) -> None:
        self._busy.clear()
        self._bytes = 0.0
