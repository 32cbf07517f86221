"""One fault again and again, until it was measured often enough."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, summed, timed

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from e2e.faults.record import Stopping

T = TypeVar("T")


class Trials(Generic[T]):
    """Results, and how many trials were void: the robot had stopped before the fault."""

    def __init__(self) -> None:
        self.results: list[T] = []
        self.void = 0

    def add(self, more: Trials[T]) -> None:
        self.results += more.results
        self.void += more.void


async def repeat(name: str, n: int, trial: Callable[[], Awaitable[T | None]]) -> Trials[T]:
    """Do a trial until `n` of them counted; None is a void one.

    Raises `MeasureError` when more than half are void: then this machine is too busy to measure.
    """
    trials: Trials[T] = Trials()
    while len(trials.results) < n:
        result = await trial()
        if result is None:
            trials.void += 1
            if trials.void > 10 + n:
                raise MeasureError(
                    f"{name}: in {trials.void} trials the robot stood before the fault came;"
                    " this machine is too busy"
                )
            continue
        trials.results.append(result)
        if len(trials.results) % 25 == 0:
            print(f"  {name} {len(trials.results)}/{n}", file=sys.stderr, flush=True)
    return trials


def told(name: str, what: str, trials: Trials[Stopping], goal_ms: float, **detail: Any) -> Row:
    """Judge the first frame that stops."""
    values_ms = [one.told_ms for one in trials.results]
    return timed(name, what, values_ms, goal_ms, **_beside(trials), **detail)


def ended(name: str, what: str, trials: Trials[Stopping], goal_ms: float, **detail: Any) -> Row:
    """Judge the end of the motion, by a frame or by the board's own watchdog."""
    values_ms = [one.ends_ms for one in trials.results]
    return timed(name, what, values_ms, goal_ms, **_beside(trials), **detail)


def travelled(name: str, what: str, trials: Trials[Stopping], goal_mm: float) -> Row:
    """Judge the way until the wheels stand."""
    return summed(name, what, "mm", [one.travelled_mm for one in trials.results], goal_mm)


def _beside(trials: Trials[Stopping]) -> dict[str, Any]:
    stands_ms = [one.stands_ms for one in trials.results]
    return {
        "wrong": sum(one.moved_again for one in trials.results),
        "void": trials.void,
        "stands_max_ms": max((at for at in stands_ms if at is not None), default=None),
        "never_stood": stands_ms.count(None),
    }
