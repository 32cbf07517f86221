"""How long it takes until picture and sound are as they were before the link changed (E6)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, Literal

from e2e.lab.report import series
from e2e.lab.report.measure import Measure
from e2e.lab.report.names import changes_s

if TYPE_CHECKING:
    from collections.abc import Callable

    from e2e.lab.results import CellResult

MARGIN_MS: Final = series.RECOVERED_MS


def began_ms(result: CellResult) -> float | None:
    """Tell when the link's changes began to count, Unix ms; None where the cell does not say."""
    told = result.told.get("changes_began_ms")
    return told if isinstance(told, float | int) and math.isfinite(told) else None


def ages(result: CellResult, of: Literal["picture", "sound"]) -> series.Series:
    """Ages over time; of the picture also how old it grew where it stood."""
    if result.readings is None:
        return []
    if of == "picture":
        return series.standing(series.picture_ages(result.readings))
    return series.sound_ages(result.readings)


def _get(
    of: Literal["picture", "sound"], which: Literal["first", "last"]
) -> Callable[[CellResult], float | None]:
    def get(result: CellResult) -> float | None:
        began = began_ms(result)
        times_s = [at_s for at_s, _ in changes_s(result.cell.profile)]
        if began is None or not times_s or (which == "first" and len(times_s) < 2):
            return None
        at_ms = began + 1000 * times_s[0 if which == "first" else -1]
        next_ms = began + 1000 * times_s[1] if which == "first" else math.inf
        return series.recovery_ms(ages(result, of), began + 1000 * times_s[0], at_ms, next_ms)

    return get


MEASURES: Final[dict[str, Measure]] = {
    measure.name: measure
    for measure in (
        Measure("picture_adapted_ms", "picture, first change", "ms", _get("picture", "first")),
        Measure("picture_recovered_ms", "picture, last change", "ms", _get("picture", "last")),
        Measure("sound_adapted_ms", "sound, first change", "ms", _get("sound", "first")),
        Measure("sound_recovered_ms", "sound, last change", "ms", _get("sound", "last")),
    )
}


def can_tell(result: CellResult, of: Literal["picture", "sound"]) -> bool:
    """Whether a missing number means that it did not recover, not that nobody looked."""
    return (
        result.status == "ok"
        and began_ms(result) is not None
        and bool(changes_s(result.cell.profile))
        and bool(ages(result, of))
    )
