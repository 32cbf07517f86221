"""What is asked for, and how it is judged: medians over the repetitions, beside others' medians."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from e2e.delay.found import apparatus, found, is_never, median, on, values, where
from e2e.delay.measures import MEASURES
from e2e.delay.names import SYSTEMS, shown
from e2e.measure.row import Row
from e2e.measure.summary import summarize

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from e2e.delay.cell import Cell, SystemName
    from e2e.delay.found import Found

    Has = Callable[["Goal", Cell], bool]
    Columns = Mapping[str, Has]
    """Which cells are a column's, by its name; the first is judged."""

_WHO: Final[dict[SystemName, str]] = {"operator": "who drives", "audio-master": "an observer"}


@dataclass(frozen=True, slots=True)
class Goal:
    """`profile` and `system` are whose cells; judged is the median of `measure` over them.

    It is `at_most` or `at_least` that, and at most `times` the best of the columns `of`, and
    `plus` (at least, where more is better). Of what has a sign, as a drift, the size is judged.
    """

    profile: str
    system: SystemName
    measure: str
    at_most: float | None = None
    at_least: float | None = None
    times: float = 1.0
    plus: float = 0.0
    of: tuple[str, ...] = ()
    more_is_better: bool = False
    content: Literal["testcard", "talking-head"] = "testcard"
    drives: bool = False
    kind: Literal["cells", "cost", "crowd"] = "cells"

    @property
    def is_floor(self) -> bool:
        return self.at_least is not None or self.more_is_better


def columns_of(systems: Iterable[SystemName]) -> dict[str, Has]:
    """Give each of these systems its column."""

    def of(system: SystemName) -> Has:
        return lambda _, cell: cell.system == system

    return {SYSTEMS[system]: of(system) for system in systems}


def derive(goals: Iterable[Goal], columns: Columns, rows: Sequence[Row]) -> list[Row]:
    """Judge every goal of which there is a cell of ours."""
    cells = found(rows)
    ours = next(iter(columns.values()))
    judged = [judge(goal, columns, cells) for goal in goals if _cells(goal, cells, ours)]
    return [*apparatus(rows), *judged]


def judge(goal: Goal, columns: Columns, cells: Sequence[Found]) -> Row:
    """Judge one. What never came, or came with no picture, has missed it."""
    measure = MEASURES[goal.measure]
    ours, *_ = columns
    values = {name: _value(goal, cells, has) for name, has in columns.items()}
    value = values[ours]
    limit = goal.at_least if goal.at_most is None else goal.at_most
    met: bool | None = value is not None
    if goal.of:
        known = [one for name in goal.of if (one := values[name]) is not None]
        best = max if goal.is_floor else min
        beside = goal.times * best(known) + goal.plus if known else None
        limit = min((one for one in (limit, beside) if one is not None), default=None)
        met = met if known or value is None else None
    if met and value is not None and limit is not None:
        met = value >= limit if goal.is_floor else value <= limit
    here = _cells(goal, cells, columns[ours])
    numbers = _numbers(goal, cells, columns[ours])
    return Row(
        key=f"{shown(goal.profile)}/{goal.system}/{goal.measure}/{goal.kind}",
        what=_what(goal),
        n=len({one.cell.repeat for one in here}),
        unit=measure.unit.lstrip("±"),
        values=values,
        spread=summarize(numbers) if numbers else None,
        judged=ours,
        goal=limit,
        at_least=goal.is_floor,
        met=met,
        load=_load(goal, here),
    )


def _what(goal: Goal) -> str:
    label, place = MEASURES[goal.measure].label, shown(goal.profile)
    if goal.kind == "cost":
        what = f"{place}: a further observer’s cost, of one core"
    elif goal.kind == "crowd":
        what = f"{place}, who drives: {label} with the crowd, more by"
    else:
        what = f"{place}, {_WHO[goal.system]}: {label}"
    if not goal.of:
        return what
    whose = f"{goal.of[0]}’s" if len(goal.of) == 1 else "the better peer’s"
    factor = "" if goal.times == 1 else f"{goal.times:.3g} × "
    more = f" + {goal.plus:g}" if goal.plus else ""
    return f"{what} ({'≥' if goal.is_floor else '≤'} {factor}{whose}{more})"


def _cells(goal: Goal, cells: Sequence[Found], has: Has) -> list[Found]:
    here = where(
        on(cells, goal.profile),
        lambda cell: (cell.browser, cell.content) == ("chromium", goal.content) and has(goal, cell),
    )
    if goal.kind != "cells":
        return where(here, lambda cell: cell.viewers > 1)

    def is_driven(cell: Cell) -> bool:
        return cell.drives == (goal.drives and cell.system == goal.system)

    return where(here, lambda cell: cell.viewers == 1 and is_driven(cell))


def _value(goal: Goal, cells: Sequence[Found], has: Has) -> float | None:
    here = _cells(goal, cells, has)
    if goal.kind == "cells" and is_never(here, goal.measure):
        return None
    numbers = _numbers(goal, cells, has)
    return summarize(numbers).median if numbers else None


def _numbers(goal: Goal, cells: Sequence[Found], has: Has) -> list[float]:
    """Give one number for each repetition."""
    here = _cells(goal, cells, has)
    if goal.kind == "cells":
        return [abs(value) for value in values(here, goal.measure)]
    found_ones = []
    for repeat in sorted({one.cell.repeat for one in here}):
        again = [one for one in here if one.cell.repeat == repeat]
        few, many = (choose(again, key=lambda one: one.cell.viewers) for choose in (min, max))
        if goal.kind == "crowd":
            few = next(
                (
                    one
                    for one in on(cells, goal.profile, goal.system)
                    if one.cell.is_alone and one.cell.repeat == repeat
                ),
                many,
            )
        low, high = few.values.get(goal.measure), many.values.get(goal.measure)
        more = many.cell.viewers - few.cell.viewers
        if low is not None and high is not None and more:
            found_ones.append((high - low) / (more if goal.kind == "cost" else 1))
    return found_ones


def _load(goal: Goal, ours: Sequence[Found]) -> str:
    """Say how long was measured, and of a crowd how many and how busy the machine was."""
    seconds = f"{max((one.cell.seconds for one in ours), default=0):g} s"
    if goal.kind == "cells":
        return seconds
    most = max(one.cell.viewers for one in ours)
    largest = [one for one in ours if one.cell.viewers == most]
    busy = median(largest, "machine_busy")
    told = "" if busy is None else f", {busy:.0f} % of the whole machine busy"
    return f"{most - 1} observers, {largest[0].cell.slow} behind a modem, {seconds}{told}"
