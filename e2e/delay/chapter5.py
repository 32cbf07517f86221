"""The rows of chapter 5 that are published: each system's figures on each link that stays as it is.

The whole of it is the page that `e2e.delay.report` makes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from e2e.delay.found import apparatus, found, on, profiles, spread, systems, where
from e2e.delay.measures import MEASURES
from e2e.delay.names import AGE, GIVEN, SYSTEMS
from e2e.measure.row import Row

if TYPE_CHECKING:
    from collections.abc import Sequence

COLUMNS: Final = tuple(SYSTEMS.values())
PUBLISHED: Final = (
    "picture_age_p50_ms",
    "picture_age_p95_ms",
    "sound_age_p50_ms",
    "absolute_skew_p95_ms",
    "pictures_per_s",
)
NOTES: Final = (
    "Chromium, one viewer, the test card; the thesis policy with an audio MU of 500 ms.",
    AGE,
    *GIVEN,
)


def derive(rows: Sequence[Row]) -> list[Row]:
    """Set the systems beside each other, a row for each link and figure, after the own errors."""
    cells = where(found(rows), lambda cell: cell.is_plain)
    derived = apparatus(rows)
    for profile in profiles(cells):
        for name in PUBLISHED:
            summed = {
                SYSTEMS[system]: one
                for system in systems(cells)
                if (one := spread(on(cells, profile, system), name))
            }
            if summed:
                measure = MEASURES[name]
                derived.append(
                    Row(
                        key=f"{profile}/{name}",
                        what=f"{profile}: {measure.label}",
                        n=max(one.n for one in summed.values()),
                        unit=measure.unit.lstrip("±"),
                        values={system: one.median for system, one in summed.items()},
                    )
                )
    return derived
