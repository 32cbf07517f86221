"""What was measured, by cell: from a suite's rows to medians over repetitions."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from e2e.delay.cell import Cell
from e2e.delay.names import SYSTEMS, in_order
from e2e.measure.summary import summarize

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from e2e.delay.cell import SystemName
    from e2e.measure.row import Row
    from e2e.measure.summary import Summary


@dataclass(frozen=True, slots=True)
class Found:
    """One cell. `values` has its figures by name: None was looked for and never reached.

    `problem` is a sentence where it failed, could not be run, or had no picture.
    """

    cell: Cell
    values: dict[str, float | None] = field(default_factory=dict)
    problem: str | None = None
    status: str = "ok"
    limits: tuple[str, ...] = ()
    """What the browser does not expose, in sentences."""


def found(rows: Iterable[Row]) -> list[Found]:
    """Take the cells of a suite's rows; rows of other cases are left out."""
    return [
        Found(
            Cell.model_validate(row.detail["cell"]),
            row.values,
            row.detail.get("problem"),
            limits=tuple(row.detail.get("limits", ())),
        )
        for row in rows
        if "cell" in row.detail
    ]


def apparatus(rows: Iterable[Row]) -> list[Row]:
    """Take the rows about the lab's own errors, which stand before all others."""
    return [row for row in rows if "cell" not in row.detail]


def where(cells: Iterable[Found], fits: Callable[[Cell], bool]) -> list[Found]:
    return [one for one in cells if fits(one.cell)]


def on(cells: Iterable[Found], profile: str, system: SystemName | None = None) -> list[Found]:
    return where(cells, lambda cell: cell.profile == profile and system in (None, cell.system))


def profiles(cells: Iterable[Found]) -> list[str]:
    return in_order(one.cell.profile for one in cells)


def systems(cells: Iterable[Found]) -> list[SystemName]:
    present = {one.cell.system for one in cells}
    return [system for system in SYSTEMS if system in present]


def values(cells: Sequence[Found], measure: str) -> list[float]:
    """Take the numbers that there are, one for each cell."""
    return [value for one in cells if (value := one.values.get(measure)) is not None]


def spread(cells: Sequence[Found], measure: str) -> Summary | None:
    """Sum up over the cells; None where nothing was measured."""
    known = values(cells, measure)
    return summarize(known) if known else None


def median(cells: Sequence[Found], measure: str) -> float | None:
    summed = spread(cells, measure)
    return None if summed is None else summed.median


def is_never(cells: Sequence[Found], measure: str) -> bool:
    """Whether in most of these cells it was looked for and never reached."""
    tried = [one.values[measure] for one in cells if measure in one.values]
    return 2 * sum(value is None for value in tried) > len(tried)
