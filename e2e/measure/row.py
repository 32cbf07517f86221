"""One row of a table: a figure, its number of measurements, its goal, and whether it is met."""

from __future__ import annotations

import math
import statistics
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ConfigDict

from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence


class Summary(BaseModel):
    """Quantiles: `p95` and `p99` are nearest-rank, so they were measured."""

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


def quantiles(values: Sequence[float]) -> dict[str, float | None]:
    """Return the columns of a row that is reported but not judged."""
    return dict(summarize(values).model_dump(include={"median", "p95", "p99", "max"}))


class Row(BaseModel):
    """`values` are numbers in `unit`, by the name of their column; None if there is none.

    The goal is that the value of the column `judged` is at most `goal`, or with `at_least` no less.
    `met` is None if there is no goal or nothing to judge. `load` is the system's load meanwhile.
    `detail` explains a result to whoever runs the suite; it is not published.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    key: str
    what: str
    n: int
    unit: str = ""
    values: dict[str, float | None]
    spread: Summary | None = None
    judged: str = ""
    goal: float | None = None
    at_least: bool = False
    met: bool | None = None
    load: str = ""
    detail: dict[str, Any] = {}


def timed(
    key: str, what: str, values_ms: Sequence[float | None], goal_ms: float, **more: Any
) -> Row:
    """Sum up times in milliseconds, as `summed` does."""
    return summed(key, what, "ms", values_ms, goal_ms, **more)


def summed(
    key: str,
    what: str,
    unit: str,
    values: Sequence[float | None],
    goal: float,
    *,
    judged: str = "max",
    wrong: int = 0,
    **detail: Any,
) -> Row:
    """Sum up repetitions; one that never ended (None) misses every goal.

    `judged` is a name of `Summary`; `wrong` counts what must never happen, and misses the goal.
    Raises `MeasureError` if nothing was measured.
    """
    if not values:
        raise MeasureError(f"{key}: nothing was measured")
    came = [value for value in values if value is not None]
    never = len(values) - len(came)
    spread = summarize(came) if came else None
    found = {} if spread is None else spread.model_dump(exclude={"n", "mean", "sd"})
    value = None if spread is None else getattr(spread, judged)
    return Row(
        key=key,
        what=what,
        n=len(values),
        unit=unit,
        values=found,
        spread=spread,
        judged=judged,
        goal=goal,
        met=value is not None and value <= goal and not never and not wrong,
        detail={"wrong": wrong, "never": never} | detail,
    )


def middle(
    key: str,
    what: str,
    unit: str,
    values: Sequence[float],
    goal: float | None = None,
    *,
    n: int,
    at_least: bool = False,
) -> Row:
    """Judge the median of values that WAX alone has; raises `MeasureError` if there are none."""
    spread = summarize(values)
    value = {"WAX": spread.median}
    return judged(key, what, unit, value, goal, n=n, at_least=at_least, spread=spread)


def counted(key: str, what: str, wrong: int, of: int, **detail: Any) -> Row:
    row = judged(key, what, "", {"max": float(wrong)}, 0.0, n=of, column="max", detail=detail)
    return row.model_copy(update={"met": row.met and of > 0})


def judged(
    key: str,
    what: str,
    unit: str,
    values: Mapping[str, float | None],
    goal: float | None = None,
    *,
    n: int,
    column: str = "WAX",
    at_least: bool = False,
    **more: Any,
) -> Row:
    """Compare values of several systems in one row; the goal is about that of `column`."""
    value = values.get(column)
    met = None
    if value is not None and goal is not None:
        met = value >= goal if at_least else value <= goal
    return Row(
        key=key,
        what=what,
        n=n,
        unit=unit,
        values=dict(values),
        judged=column,
        goal=goal,
        at_least=at_least,
        met=met,
        **more,
    )
