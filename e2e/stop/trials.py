"""Repeats one fault until it has been measured often enough."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, timed

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from e2e.stop.record import Stopping

T = TypeVar("T")


class Trials(Generic[T]):
    """Results, and the number of void trials, in which the robot had stopped before the fault."""

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


def told(
    name: str,
    what: str,
    trials: Trials[Stopping],
    goal_ms: float,
    *,
    by_board: bool = False,
    **detail: Any,
) -> Row:
    """Judge the first stopping frame; with `by_board` the board's watchdog may come first."""
    found = trials.results
    stands_ms = [one.stands_ms for one in found if one.stands_ms is not None]
    return timed(
        name,
        what,
        [one.ends_ms if by_board else one.told_ms for one in found],
        goal_ms,
        wrong=sum(one.moved_again for one in found),
        void=trials.void,
        stands_max_ms=max(stands_ms, default=None),
        never_stood=len(found) - len(stands_ms),
        **detail,
    )
