"""What a fault came to: the figure, how often it was measured, the goal, and whether it is met."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

from e2e.bench.spread import spread
from e2e.faults.errors import FaultError

if TYPE_CHECKING:
    from collections.abc import Sequence


@dataclass(frozen=True, slots=True)
class Figure:
    """One row of the table.

    `judged` is the part of the spread that the goal is about. `wrong` counts what must never
    happen, such as a late command that moved the robot, with `wrong_is` for what; `void` the trials
    that were repeated because the machine, not the robot, had stopped before the fault.
    """

    name: str
    what: str
    unit: str
    n: int
    p50: float | None
    p99: float | None
    max: float | None
    goal: float | None
    judged: str
    met: bool
    wrong: int = 0
    void: int = 0
    detail: dict[str, Any] = field(default_factory=dict)

    def as_json(self) -> dict[str, Any]:
        return asdict(self)


def timed(
    name: str,
    what: str,
    values_ms: Sequence[float | None],
    goal_ms: float,
    *,
    judged: str = "max",
    wrong: int = 0,
    void: int = 0,
    **detail: Any,
) -> Figure:
    """Sum up times, as `summed` does."""
    return summed(
        name, what, "ms", values_ms, goal_ms, judged=judged, wrong=wrong, void=void, **detail
    )


def summed(
    name: str,
    what: str,
    unit: str,
    values: Sequence[float | None],
    goal: float,
    *,
    judged: str = "max",
    wrong: int = 0,
    void: int = 0,
    **detail: Any,
) -> Figure:
    """Sum up; what never came to an end (None) misses every goal. Raises `FaultError`."""
    if not values:
        raise FaultError(f"{name}: nothing was measured")
    came = [value for value in values if value is not None]
    missing = len(values) - len(came)
    found = spread(came) if came else None
    value = None if found is None else getattr(found, judged)
    return Figure(
        name=name,
        what=what,
        unit=unit,
        n=len(values),
        p50=None if found is None else found.p50,
        p99=None if found is None else found.p99,
        max=None if found is None else found.max,
        goal=goal,
        judged=judged,
        met=value is not None and value <= goal and not missing and not wrong,
        wrong=wrong,
        void=void,
        detail=({"never": missing} if missing else {}) | detail,
    )


def counted(name: str, what: str, wrong: int, of: int, **detail: Any) -> Figure:
    """Sum up what must never happen, `wrong` of so many."""
    return Figure(
        name=name,
        what=what,
        unit="",
        n=of,
        p50=None,
        p99=None,
        max=float(wrong),
        goal=0.0,
        judged="max",
        met=wrong == 0 and of > 0,
        wrong=wrong,
        detail=detail,
    )
