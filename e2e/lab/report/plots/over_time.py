"""Lines of several systems over time, from the raw series: skew, picture age, sound age."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal

from e2e.lab.report import pick, recovery, series
from e2e.lab.report.blocks import Plot
from e2e.lab.report.drawing import data_uri, legend, log_ages, look, panel
from e2e.lab.report.names import changes_s

if TYPE_CHECKING:
    from collections.abc import Callable

    from e2e.lab.report.blocks import Entry
    from e2e.lab.report.pick import Entries
    from e2e.lab.report.series import Series
    from e2e.lab.results import CellResult

POINTS: Final = 400
EARLY_MS: Final = -45.0
LATE_MS: Final = 125.0
"""ITU-R BT.1359: from here on people notice that the sound is early, or late."""


def skew(entries: Entries) -> tuple[Plot, ...]:
    """Draw each profile's skew, second by second."""
    plots = []
    for profile in pick.profiles(entries):
        lines = _lines(pick.on(entries, profile), _skew, _from_ms)
        if not lines:
            continue
        with panel() as (drawing, axes):
            axes.axhspan(EARLY_MS, LATE_MS, color="#F0F0F0", linewidth=0)
            axes.axhline(0, color="#999999", linewidth=0.8)
            for entry, points in lines:
                axes.plot(*_columns(points), **look(entry.cell.system))
            axes.set_xlabel("s since the measuring began")
            axes.set_ylabel("skew, ms")
            axes.set_title(profile)
            legend(drawing)
            plots.append(
                Plot(
                    data_uri(drawing),
                    f"Skew over time on {profile}",
                    f"{profile}: sound’s age less picture’s, at each second’s burst. Grey: what "
                    "people do not notice (ITU-R BT.1359).",
                    tuple(entry for entry, _ in lines),
                    "readings.sound, readings.pictures",
                )
            )
    return tuple(plots)


def ages(entries: Entries, of: Literal["picture", "sound"]) -> tuple[Plot, ...]:
    """Draw each profile's age over time; where the link changes, the changes are marked."""
    plots = []
    for profile in pick.profiles(entries):
        here = pick.on(entries, profile)
        changes = changes_s(profile)
        is_marked = bool(changes) and any(
            recovery.began_ms(entry.result) is not None for entry in here
        )
        lines = _lines(
            here,
            lambda result: recovery.ages(result, of),
            recovery.began_ms if is_marked else _from_ms,
        )
        if not lines:
            continue
        with panel() as (drawing, axes):
            for entry, points in lines:
                axes.plot(
                    *_columns(points),
                    **look(entry.cell.system),
                )
            log_ages(axes)
            for number, (at_s, words) in enumerate(changes if is_marked else []):
                axes.axvline(at_s, color="#333333", linewidth=0.9, linestyle=":")
                axes.text(
                    at_s,
                    1.0 - 0.08 * (number % 3),
                    f" {words}",
                    fontsize=6.5,
                    va="top",
                    bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.3, "alpha": 0.8},
                    transform=axes.get_xaxis_transform(),
                )
            axes.set_xlabel(
                "s since the changes began to count" if is_marked else "s since the measuring began"
            )
            axes.set_ylabel(f"{of}’s age, ms")
            axes.set_title(f"{profile}: {of}")
            legend(drawing)
            unmarked = "" if is_marked or not changes else " No cell says when the changes began."
            plots.append(
                Plot(
                    data_uri(drawing),
                    f"Age of the {of} over time on {profile}",
                    f"{profile}: {of}’s age over time"
                    + (
                        ", growing while one picture stands."
                        if of == "picture"
                        else ". A burst does not say which second it is of: after a break whole "
                        "seconds may be missing."
                    )
                    + unmarked,
                    tuple(entry for entry, _ in lines),
                    "readings.pictures" if of == "picture" else "readings.sound",
                )
            )
    return tuple(plots)


def _lines(
    entries: Entries,
    of: Callable[[CellResult], Series],
    zero: Callable[[CellResult], float | None],
) -> list[tuple[Entry, Series]]:
    """Of each system the first cell that was measured: (s since zero, value)."""
    found = []
    for system in pick.systems(entries):
        entry = pick.first_ok(pick.where(entries, lambda cell, of=system: cell.system == of))  # type: ignore[misc]  # no type for a default
        zero_ms = zero(entry.result) if entry else None
        if entry is None or zero_ms is None:
            continue
        points = [((at_ms - zero_ms) / 1000, value) for at_ms, value in of(entry.result)]
        points = series.thinned(series.sane(points), POINTS)
        if points:
            found.append((entry, points))
    return found


def _columns(points: Series) -> tuple[list[float], list[float]]:
    return [at_s for at_s, _ in points], [value for _, value in points]


def _from_ms(result: CellResult) -> float | None:
    return result.figures.from_ms if result.figures else None


def _skew(result: CellResult) -> Series:
    if result.readings is None:
        return []
    pictures = series.picture_ages(result.readings)
    return series.skews(pictures, recovery.ages(result, "sound"))
