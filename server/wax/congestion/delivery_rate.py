"""What comes out of a queue that is never empty comes at the rate of the link."""

from __future__ import annotations

import math
from collections import deque
from itertools import pairwise
from typing import Final

_WINDOW_S: Final = 0.8
_LEAST_S: Final = 0.06
_LEAST_PACKETS: Final = 3
_MARGIN_S: Final = 0.005


class DeliveryRate:
    """Told of every packet that arrived, in the order of their sending; times in seconds."""

    def __init__(self) -> None:
        self._run: deque[tuple[float, float]] = deque()  # arrival, bytes that came until then
        self._bytes = 0.0
        self._arrived_s = -math.inf

    def add(self, reached_s: float, arrived_s: float, size_bytes: float) -> None:
        """Count `size_bytes` that came by `arrived_s`.

        `reached_s` is when the packet would have come had nobody been before it. Where that is
        not after the arrival of the one before, the two have left the queue back to back.
        """
        if not self._arrived_s > reached_s + _MARGIN_S or arrived_s < self._arrived_s:
            self.clear()
        self._bytes += size_bytes
        self._arrived_s = arrived_s
        self._run.append((arrived_s, self._bytes))
        while len(self._run) > 2 and self._run[1][0] < arrived_s - _WINDOW_S:
            self._run.popleft()

    def rate_bps(self) -> float | None:
        """Return the rate of the last 0.8 s without a pause; None where that is too little."""
        if len(self._run) < _LEAST_PACKETS:
            return None
        steps = [(b - a, later - total) for (a, total), (b, later) in pairwise(self._run)]
        # A stall is a pause of the link, but none of its rate.
        longest = max(steps)
        took_s = sum(step_s for step_s, _ in steps) - longest[0]
        size_bytes = sum(size for _, size in steps) - longest[1]
        return size_bytes * 8 / took_s if took_s >= _LEAST_S else None

    def clear(self) -> None:
        self._run.clear()
        self._bytes = 0.0
