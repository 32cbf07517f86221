"""Every cell with its key, what became of it, all its figures, and where its series are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from e2e.lab.report import recovery
from e2e.lab.report.measures import MEASURES

if TYPE_CHECKING:
    from e2e.lab.report.blocks import Entry
    from e2e.lab.report.pick import Entries
    from e2e.lab.results import CellResult

TOLD: Final = ("viewer.streams.", "link.")
"""Of what a system tells of itself, what the policy did and how late the link was; the JSON has
all of it."""


@dataclass(frozen=True, slots=True)
class Listed:
    """`series` are (path in the JSON, what is there and how many rows)."""

    entry: Entry
    facts: tuple[tuple[str, str], ...]
    figures: tuple[tuple[str, str], ...]
    series: tuple[tuple[str, str], ...]
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
    told = [
        f"{name} {value:.4g}" if isinstance(value, float) else f"{name} {value}"
        for name, value in result.told.items()
        if name.startswith(TOLD)
    ]
    if result.told:
        found.append(("told of itself", ", ".join([*told] or ["see the JSON"])))
    return found


def _series(entry: Entry) -> list[tuple[str, str]]:
    readings, figures = entry.result.readings, entry.result.figures
    found: list[tuple[str, str]] = []
    if readings is not None:
        rows = {
            "pictures": len(readings.pictures.at_ms),
            "sound": len(readings.sound.start_ms),
            "counters": len(readings.counters.at_ms),
            "commands": len(readings.commands.at_ms),
            "set_points": len(readings.set_points.at_ms),
            "connections": len(readings.connections.at_ms),
        }
        found.append((f"{entry.path}.readings", _counted(rows)))
    if figures is not None:
        rows = {
            "tone_pauses": len(figures.tone_pauses.at_ms),
            "concealed_pauses": len(figures.concealed_pauses.at_ms),
        }
        found.append((f"{entry.path}.figures", _counted(rows)))
    if entry.result.told:
        found.append((f"{entry.path}.told", f"{len(entry.result.told)} facts"))
    return found


def _counted(rows: dict[str, int]) -> str:
    return ", ".join(f"{name} ({number})" for name, number in rows.items())
