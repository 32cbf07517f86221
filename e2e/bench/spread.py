"""How many numbers lie: what a median alone would hide."""

from __future__ import annotations

import math
import statistics
from dataclasses import dataclass
from typing import TYPE_CHECKING

from e2e.bench.errors import BenchError

if TYPE_CHECKING:
    from collections.abc import Sequence


@dataclass(frozen=True, slots=True)
class Spread:
    """`p50` is the usual median; `p95` and `p99` are nearest-rank, so values that were measured."""

    n: int
    min: float
    p50: float
    p95: float
    p99: float
    max: float
    mean: float
    sd: float


def spread(values: Sequence[float]) -> Spread:
    """Sum up; raises `BenchError` when there is nothing to."""
    if not values:
        raise BenchError("nothing was measured")
    ordered = sorted(values)

    def rank(fraction: float) -> float:
        return ordered[max(0, math.ceil(fraction * len(ordered)) - 1)]

    return Spread(
        n=len(ordered),
        min=ordered[0],
        p50=statistics.median(ordered),
        p95=rank(0.95),
        p99=rank(0.99),
        max=ordered[-1],
        mean=statistics.fmean(ordered),
        sd=statistics.stdev(ordered) if len(ordered) > 1 else 0.0,
    )
