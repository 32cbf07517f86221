"""What the instrument makes of a clock that lies, pure."""

from __future__ import annotations

import math
import statistics
from typing import TYPE_CHECKING

from e2e.lab.instrument.cards import LIE_MS, lies

if TYPE_CHECKING:
    from collections.abc import Iterable

_LEAST_LIES = 4


def shift_ms(read: Iterable[tuple[float, float]]) -> float | None:
    """Return how much older the lying seconds were read than the honest ones about them.

    `read` are stamps as they were read, and ages. It is the median over all lying seconds that
    have both their neighbours: of each second the median, less the mean of those beside it. None of
    fewer than 4.
    """
    seconds: dict[int, list[float]] = {}
    for stamp_ms, age_ms in read:
        # Both the stamp and what it would truly be must say the same.
        if lies(stamp_ms) == lies(stamp_ms + LIE_MS):
            seconds.setdefault(math.floor((stamp_ms + 500) / 1000), []).append(age_ms)
    medians = {second: statistics.median(ages) for second, ages in seconds.items()}
    shifts = [
        median - (medians[second - 1] + medians[second + 1]) / 2
        for second, median in medians.items()
        if second % 2 == 1 and second - 1 in medians and second + 1 in medians
    ]
    return statistics.median(shifts) if len(shifts) >= _LEAST_LIES else None


def difference_ms(first: float | None, second: float | None) -> float | None:
    """Return by how much two readings of the same differ; None where one is missing."""
    return None if first is None or second is None else abs(first - second)


def within(value: float | None, expected: float, limit: float) -> bool:
    """Tell whether it is as expected; what was not read is not."""
    return value is not None and abs(value - expected) <= limit
