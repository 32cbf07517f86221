"""The numbers that only the goals need, each made of a cell's raw series."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Final

from e2e.lab.instrument.pauses import concealed_pauses, tone_pauses
from e2e.lab.instrument.quantities import quantiles
from e2e.lab.report import series
from e2e.lab.report.measure import Measure, from_readings
from e2e.lab.report.names import changes_s
from e2e.lab.report.recovery import began_ms

if TYPE_CHECKING:
    from collections.abc import Callable

    from e2e.lab.figures import Figures
    from e2e.lab.readings import Readings
    from e2e.lab.results import CellResult

JOINED_MS: Final = 3000.0
"""So long after the first picture skew counts."""
FRESH_MS: Final = 300.0
FULL: Final = (640, 480)
"""What all systems are asked to send."""
FULL_RATE: Final = 27.0
"""Nine tenths of the 30 pictures a second that all are asked for."""
HELD_MS: Final = 1000.0
ENDED_MS: Final = 5000.0
"""With no picture for so long at the end of a cell nobody is connected."""
LEAST_AT: Final = (160, 120)


def skew_p95_ms(readings: Readings, figures: Figures) -> float | None:
    """p95 of the absolute skew from 3 s after joining on, joining being the first picture.

    Sound that comes later than that has no skew before; the figure of the first sound tells of it.
    """
    if readings.first_picture_ms is None:
        return None
    from_ms = readings.first_picture_ms + JOINED_MS
    pictures, sounds = series.picture_ages(readings), series.sound_ages(readings)
    found = quantiles(
        [
            abs(skew)
            for at_ms, skew in series.skews(pictures, sounds)
            if from_ms <= at_ms <= figures.to_ms
        ]
    )
    return found.p95 if found else None


def concealed_share(readings: Readings, figures: Figures) -> float | None:
    """Of the samples that were played from the first sound on, those that were made up."""
    if readings.first_sound_ms is None:
        return None
    counters = readings.counters
    rows = [
        (played, concealed)
        for at_ms, played, concealed in zip(
            counters.at_ms, counters.played_samples, counters.concealed_samples, strict=True
        )
        if played is not None
        and concealed is not None
        and readings.first_sound_ms <= at_ms <= figures.to_ms
    ]
    if len(rows) < 2 or rows[-1][0] <= rows[0][0]:
        return None
    return (rows[-1][1] - rows[0][1]) / (rows[-1][0] - rows[0][0])


def pauses_ms(readings: Readings, from_ms: float, to_ms: float) -> list[float]:
    """Lengths of the gaps that are heard, 30 ms or more, and of contiguous concealments of 100.

    One that is both is there twice.
    """
    return [
        *tone_pauses(readings.sound, from_ms, to_ms).length_ms,
        *concealed_pauses(readings.counters, from_ms, to_ms).length_ms,
    ]


def pauses(readings: Readings, figures: Figures) -> float | None:
    """How often the sound paused since it was first heard, as heard or as counted."""
    if readings.first_sound_ms is None:
        return None
    span = readings.first_sound_ms, figures.to_ms
    heard = len(tone_pauses(readings.sound, *span).length_ms)
    counted = len(concealed_pauses(readings.counters, *span).length_ms)
    return float(max(heard, counted))


def longest_pause_ms(readings: Readings, figures: Figures) -> float | None:
    if readings.first_sound_ms is None:
        return None
    return max(pauses_ms(readings, readings.first_sound_ms, figures.to_ms), default=0.0)


def sized(readings: Readings, least: tuple[int, int]) -> list[tuple[float, bool]]:
    """When each new picture was shown, and whether it was at least so many pixels wide and high."""
    pictures = readings.pictures
    # Runs of older versions have no heights.
    heights = pictures.height or [least[1]] * len(pictures.width)
    found: list[tuple[float, bool]] = []
    before = None
    for at_ms, stamp_ms, width, height in zip(
        pictures.at_ms, pictures.stamp_ms, pictures.width, heights, strict=False
    ):
        if stamp_ms is None or stamp_ms != before:
            found.append((at_ms, width >= least[0] and height >= least[1]))
        before = stamp_ms
    return found


def _rate(least: tuple[int, int]) -> Callable[[Readings, Figures], float | None]:
    def rate(readings: Readings, figures: Figures) -> float | None:
        if figures.to_ms <= figures.from_ms or not readings.pictures.at_ms:
            return None
        shown = [
            large
            for at_ms, large in sized(readings, least)
            if figures.from_ms <= at_ms <= figures.to_ms
        ]
        return 1000 * sum(shown) / (figures.to_ms - figures.from_ms)

    return rate


def breaks(readings: Readings, figures: Figures) -> float | None:
    """How often the page's connection changed its state after it was connected; 0 is never.

    An end at which no picture comes any more counts as one. None where it was not looked at.
    """
    states = readings.connections.state
    if "connected" not in states:
        return None
    changes = len(states) - 1 - states.index("connected")
    shown = readings.pictures.at_ms
    is_over = not shown or figures.to_ms - shown[-1] > ENDED_MS
    return float(changes + is_over)


def set_points_per_s(readings: Readings, figures: Figures) -> float | None:
    """How often the page handed a set-point to its channel; None where it never did."""
    sent = readings.set_points.at_ms
    if not sent or figures.to_ms <= figures.from_ms:
        return None
    inside = sum(figures.from_ms <= at_ms <= figures.to_ms for at_ms in sent)
    return 1000 * inside / (figures.to_ms - figures.from_ms)


def fresh_after_ms(ages: series.Series, step_ms: float, end_ms: float) -> float | None:
    """From a step until the picture is, and stays for 1 s, younger than `FRESH_MS`.

    Between two pictures the older one grows old. None where that is not reached before `end_ms`.
    """
    fresh_ms = step_ms
    last_ms = max([at_ms for at_ms, _ in ages if at_ms <= end_ms], default=step_ms)
    spans = [*pairwise(ages), *([(ages[-1], (end_ms, 0.0))] if ages else [])]
    for (at_ms, age_ms), (next_ms, _) in spans:
        stale_ms = at_ms + max(0.0, FRESH_MS - age_ms)
        if stale_ms >= next_ms or next_ms <= step_ms:
            continue
        if stale_ms - fresh_ms >= HELD_MS:
            break
        fresh_ms = next_ms
    return fresh_ms - step_ms if last_ms - fresh_ms >= HELD_MS else None


def full_after_ms(shown: list[tuple[float, bool]], from_ms: float) -> float | None:
    """From a moment until pictures come in full size at the full rate for 1 s; None if never."""
    times = [at_ms for at_ms, _ in shown]
    for place, (at_ms, _) in enumerate(shown):
        if at_ms < from_ms or times[-1] < at_ms + HELD_MS:
            continue
        held = [large for when_ms, large in shown[place:] if when_ms < at_ms + HELD_MS]
        if all(held) and len(held) >= FULL_RATE:
            return at_ms - from_ms
    return None


def _step(
    get: Callable[[Readings, Figures, float, float], float | None],
) -> Callable[[CellResult], float | None]:
    """Give `get` when the link was made worse, and when it was whole again."""

    def found(result: CellResult) -> float | None:
        began, changes = began_ms(result), changes_s(result.cell.profile)
        readings, figures = result.readings, result.figures
        if began is None or len(changes) < 2 or readings is None or figures is None:
            return None
        return get(readings, figures, began + 1000 * changes[0][0], began + 1000 * changes[-1][0])

    return found


def _drift(name: str) -> Callable[[CellResult], float | None]:
    def get(result: CellResult) -> float | None:
        value = getattr(result.figures, name, None)
        return None if value is None else abs(float(value))

    return get


_ALL: Final = (
    Measure(
        "goal_skew_p95_ms",
        "|skew| p95 from 3 s after joining",
        "ms",
        from_readings(skew_p95_ms),
        "of each second’s burst; joining is the first picture",
    ),
    Measure("goal_concealed_share", "concealed sound", "share", from_readings(concealed_share)),
    Measure("goal_pauses", "audible pauses", "1", from_readings(pauses)),
    Measure("goal_longest_pause_ms", "longest pause", "ms", from_readings(longest_pause_ms)),
    Measure("goal_pictures_640_per_s", "pictures at 640×480", "per s", from_readings(_rate(FULL))),
    Measure(
        "goal_pictures_160_per_s",
        "pictures at 160×120 or more",
        "per s",
        from_readings(_rate(LEAST_AT)),
    ),
    Measure("goal_breaks", "breaks of the connection", "1", from_readings(breaks)),
    Measure("goal_set_points_per_s", "set-points sent", "per s", from_readings(set_points_per_s)),
    Measure(
        "goal_picture_drift_ms_per_min",
        "picture’s drift, absolute, a minute",
        "ms",
        _drift("picture_drift_ms_per_min"),
    ),
    Measure(
        "goal_sound_drift_ms_per_min",
        "sound’s drift, absolute, a minute",
        "ms",
        _drift("sound_drift_ms_per_min"),
    ),
    Measure(
        "goal_fresh_after_ms",
        f"picture under {FRESH_MS:.0f} ms again",
        "ms",
        _step(
            lambda readings, figures, step_ms, _: fresh_after_ms(
                series.picture_ages(readings), step_ms, figures.to_ms
            )
        ),
    ),
    Measure(
        "goal_step_pause_ms",
        "longest pause after the step",
        "ms",
        _step(
            lambda readings, figures, step_ms, _: max(
                pauses_ms(readings, step_ms, figures.to_ms), default=0.0
            )
        ),
    ),
    Measure(
        "goal_full_after_ms",
        "full quality after recovery",
        "ms",
        _step(lambda readings, _, __, whole_ms: full_after_ms(sized(readings, FULL), whole_ms)),
    ),
)
MEASURES: Final[dict[str, Measure]] = {measure.name: measure for measure in _ALL}
