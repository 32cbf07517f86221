"""Every cell with its key, what became of it, all its figures, and where its series are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from e2e.lab.report import recovery
from e2e.lab.report.measures import MEASURES

if TYPE_CHECKING:
    from e2e.lab.report.blocks import Entry
    from e2e.lab.report.pick import Entries
    from e2e.lab.results import CellResult


@dataclass(frozen=True, slots=True)
class Listed:
    """`series` are (path in the JSON, how many rows)."""

    entry: Entry
    facts: tuple[tuple[str, str], ...]
    figures: tuple[tuple[str, str], ...]
    series: tuple[tuple[str, int], ...]
    limits: tuple[str, ...]


def listed(cells: Entries) -> tuple[Listed, ...]:
    return tuple(_listed(entry) for entry in cells)


def _listed(entry: Entry) -> Listed:
    result = entry.result
    measures = [*MEASURES.values(), *(recovery.MEASURES.values() if _changes(result) else ())]
    return Listed(
        entry,
        tuple(_facts(result)),
        tuple(
            (measure.label, measure.with_unit(value))
            for measure in measures
            if (value := measure.of(result)) is not None
        ),
        tuple(_series(entry)),
        tuple(result.readings.limits) if result.readings else (),
    )


def _changes(result: CellResult) -> bool:
    return result.cell.experiment == "E6"


def _facts(result: CellResult) -> list[tuple[str, str]]:
    found = [("started", result.started_utc), ("took", f"{result.took_s:.1f} s")]
    for name, way in (("link, down", result.down), ("link, up", result.up)):
        if way is not None:
            found.append(
                (
                    name,
                    f"{way.packets} packets, {way.bytes / 1000:.1f} kB, {way.queue_drops} dropped "
                    f"by the queue, {way.losses} lost",
                )
            )
    found += [
        (name, f"{value:.6g}" if isinstance(value, float) and abs(value) < 1e6 else str(value))
        for name, value in result.told.items()
    ]
    return found


def _series(entry: Entry) -> list[tuple[str, int]]:
    readings, figures = entry.result.readings, entry.result.figures
    found: list[tuple[str, int]] = []
    if readings is not None:
        for name in ("pictures", "sound", "counters", "commands"):
            columns = getattr(readings, name)
            rows = len(columns.start_ms if name == "sound" else columns.at_ms)
            found.append((f"{entry.path}.readings.{name}", rows))
    if figures is not None:
        found += [
            (f"{entry.path}.figures.{name}", len(getattr(figures, name).at_ms))
            for name in ("tone_pauses", "concealed_pauses")
        ]
    return found
