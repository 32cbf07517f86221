"""Which cells of a run belong to which table.

By what they are, not by their experiment: a cell that two experiments need is measured once, for
the first of them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from e2e.lab.plan import CHANGING
from e2e.lab.report.blocks import Entry
from e2e.lab.report.names import SYSTEMS, in_order

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from e2e.lab.cell import Cell, SystemName
    from e2e.lab.results import Run

Entries = tuple[Entry, ...]


def entries(run: Run) -> Entries:
    return tuple(Entry(index, result) for index, result in enumerate(run.cells))


def where(cells: Entries, fits: Callable[[Cell], bool]) -> Entries:
    return tuple(entry for entry in cells if fits(entry.cell))


def alone(cells: Entries) -> Entries:
    """One viewer with Chromium before the test card, who does not drive."""
    return where(
        cells,
        lambda cell: (
            (cell.viewers, cell.browser, cell.content) == (1, "chromium", "testcard")
            and not cell.drives
        ),
    )


def common(cells: Entries) -> Entries:
    """Of those, the ones on a link that does not change."""
    return where(alone(cells), lambda cell: not is_changing(cell))


def intra(cells: Entries) -> Entries:
    """Take the thesis policy with any MU; on links that change what was measured for E1."""
    return where(
        alone(cells),
        lambda cell: cell.system == "thesis" and (cell.experiment == "E1" or not is_changing(cell)),
    )


def plain(cells: Entries) -> Entries:
    """Of the common ones, of the thesis policy those with its own MU of 500 ms."""
    return where(common(cells), is_500)


def changing(cells: Entries) -> Entries:
    """On a link that changes: of each system those that were watched for longest."""
    here = where(alone(cells), lambda cell: is_changing(cell) and is_500(cell))
    longest: dict[tuple[str, str], float] = {}
    for entry in here:
        key = (entry.cell.profile, entry.cell.system)
        longest[key] = max(longest.get(key, 0.0), entry.cell.seconds)
    return where(here, lambda cell: cell.seconds == longest[cell.profile, cell.system])


def compared(cells: Entries, differs: Callable[[Cell], bool]) -> Entries:
    """Those that differ, and those of the same system on the same profile that do not."""
    wanted = {(entry.cell.profile, entry.cell.system) for entry in where(cells, differs)}
    return where(cells, lambda cell: (cell.profile, cell.system) in wanted and is_500(cell))


def is_changing(cell: Cell) -> bool:
    return cell.experiment == "E6" or cell.profile in CHANGING


def is_500(cell: Cell) -> bool:
    return mu_ms(cell) == 500


def on(cells: Entries, profile: str, system: SystemName | None = None) -> Entries:
    return where(
        cells,
        lambda cell: cell.profile == profile and system in (None, cell.system),
    )


def mu_ms(cell: Cell) -> int:
    return 500 if cell.audio_mu_ms is None else cell.audio_mu_ms


def profiles(cells: Iterable[Entry]) -> list[str]:
    return in_order(entry.cell.profile for entry in cells)


def systems(cells: Iterable[Entry]) -> list[SystemName]:
    present = {entry.cell.system for entry in cells}
    return [system for system in SYSTEMS if system in present]


def first_ok(cells: Entries) -> Entry | None:
    """Find the first that was measured and has its raw series."""
    return next(
        (entry for entry in cells if entry.result.status == "ok" and entry.result.readings), None
    )
