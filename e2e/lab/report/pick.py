"""Which cells of a run belong to which table."""

from __future__ import annotations

from typing import TYPE_CHECKING

from e2e.lab.report.blocks import Entry
from e2e.lab.report.names import SYSTEMS, in_order

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from e2e.lab.cell import Cell, Experiment, SystemName
    from e2e.lab.results import Run

Entries = tuple[Entry, ...]


def entries(run: Run) -> Entries:
    return tuple(Entry(index, result) for index, result in enumerate(run.cells))


def of(cells: Entries, *experiments: Experiment) -> Entries:
    return where(cells, lambda cell: cell.experiment in experiments)


def where(cells: Entries, fits: Callable[[Cell], bool]) -> Entries:
    return tuple(entry for entry in cells if fits(entry.cell))


def plain(cells: Entries) -> Entries:
    """One viewer with Chromium before the test card; of the thesis policy the MU of 500 ms."""
    return where(
        cells,
        lambda cell: (
            cell.viewers == 1
            and cell.browser == "chromium"
            and cell.content == "testcard"
            and mu_ms(cell) == 500
        ),
    )


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
