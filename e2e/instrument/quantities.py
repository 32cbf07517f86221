"""Small arithmetic on series: how they lie and how they drift."""

from __future__ import annotations

import math
import statistics
from typing import TYPE_CHECKING, Final

import numpy as np

from e2e.measure.summary import Summary, summarize

if TYPE_CHECKING:
    from collections.abc import Sequence

_LEAST_SPAN_MS: Final = 5000.0
_LEAST_POINTS: Final = 5


def summed(values: Sequence[float]) -> Summary | None:
    """Sum up; None of nothing."""
    return summarize(values) if values else None


def drift_per_min(at_ms: Sequence[float], values: Sequence[float]) -> float | None:
    """Return the robust slope (Theil–Sen) of `values` over time, per minute.

    Of the medians of each second, so that a second with many values has no more say than one with
    few. None over less than 5 s or 5 such seconds.
    """
    seconds: dict[int, list[tuple[float, float]]] = {}
    for at, value in zip(at_ms, values, strict=True):
        seconds.setdefault(math.floor(at / 1000), []).append((at, value))
    if len(seconds) < _LEAST_POINTS:
        return None
    points = [
        (statistics.median(at for at, _ in rows), statistics.median(value for _, value in rows))
        for _, rows in sorted(seconds.items())
    ]
    if points[-1][0] - points[0][0] < _LEAST_SPAN_MS:
        return None
    times, medians = np.array(points).T
    first, second = np.triu_indices(len(times), k=1)
    slopes = (medians[second] - medians[first]) / (times[second] - times[first])
    return float(np.median(slopes)) * 60_000


def rate_per_s(at_ms: Sequence[float], counts: Sequence[float | None]) -> float | None:
    """Return how fast a count grew from the first to the last look that had it."""
    known = [(at, count) for at, count in zip(at_ms, counts, strict=True) if count is not None]
    if len(known) < 2 or known[-1][0] <= known[0][0]:
        return None
    return 1000 * (known[-1][1] - known[0][1]) / (known[-1][0] - known[0][0])
