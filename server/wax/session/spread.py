"""Median and maximum of any number of measurements, in little memory. Pure."""

from __future__ import annotations

import math
from collections import Counter
from typing import Final

_STEP: Final = math.log(1.05)
"""Measurements are counted in steps of 5 %, which bounds the median's error."""
_LEAST: Final = 0.01
_MOST: Final = 1e9


class Spread:
    """Counts measurements from 0 to `_MOST`; all others, NaN too, are ignored."""

    def __init__(self) -> None:
        self._counts: Counter[int | None] = Counter()
        self.worst: float | None = None

    def add(self, value: float | None) -> None:
        """Add a measurement; None is unknown."""
        if value is None or not 0 <= value <= _MOST:
            return
        self._counts[None if value < _LEAST else round(math.log(value) / _STEP)] += 1
        self.worst = value if self.worst is None else max(self.worst, value)

    @property
    def median(self) -> float | None:
        """The median, None without measurements."""
        half = (self._counts.total() + 1) // 2
        below = 0
        for step in sorted(self._counts, key=lambda one: -math.inf if one is None else one):
            below += self._counts[step]
            if below >= half:
                middle = 0.0 if step is None else math.exp(step * _STEP)
                return min(middle, self.worst or 0.0)
        return None
