"""Summary statistics, because a median alone hides the tail."""

from __future__ import annotations

import math
import statistics
from typing import TYPE_CHECKING

from pydantic import BaseModel, ConfigDict

from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from collections.abc import Sequence


class Summary(BaseModel):
    """`median` is the usual one; `p95` and `p99` are nearest-rank, so values that were measured."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    n: int
    min: float
    median: float
    p95: float
    p99: float
    max: float
    mean: float
    sd: float


def summarize(values: Sequence[float]) -> Summary:
    """Summarise the values; raises `MeasureError` if there are none."""
    if not values:
        raise MeasureError("nothing was measured")
    ordered = sorted(values)

    def rank(fraction: float) -> float:
        return ordered[max(0, math.ceil(fraction * len(ordered)) - 1)]

    return Summary(
        n=len(ordered),
        min=ordered[0],
        median=statistics.median(ordered),
        p95=rank(0.95),
        p99=rank(0.99),
        max=ordered[-1],
        mean=statistics.fmean(ordered),
        sd=statistics.stdev(ordered) if len(ordered) > 1 else 0.0,
    )
