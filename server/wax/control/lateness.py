"""A histogram of how late the loop's ticks have been since the start, for monitoring. Pure."""

from __future__ import annotations

from bisect import bisect_left
from typing import Final

BOUNDS_MS: Final = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 40.0, 100.0, 200.0)


class Lateness:
    """`counts` has a bucket up to each bound of `BOUNDS_MS`, and one for everything above."""

    def __init__(self) -> None:
        self.counts = [0] * (len(BOUNDS_MS) + 1)
        self.sum_s = 0.0

    def add(self, late_s: float) -> None:
        self.counts[bisect_left(BOUNDS_MS, late_s * 1000)] += 1
        self.sum_s += late_s
