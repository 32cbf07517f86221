"""What the plots and some figures need of the raw series: ages, skew, gaps, recovery."""

from __future__ import annotations

import math
from bisect import bisect_left
from itertools import pairwise
from statistics import median
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.lab.figures import Figures
    from e2e.lab.readings import Readings, Sound

Series = list[tuple[float, float]]
"""(Unix ms, value), in the order of the times."""

MOST: Final = 1e9
"""Eleven days in ms."""
LATE_MS: Final = 100.0
"""One video MU: a picture this much older than the cell's youngest is late (after 5.2.1.1)."""
STALL_MS: Final = 200.0
"""Two video MUs: where ten pictures a second are the rule, one is missing (after 5.3)."""
RECOVERED_MS: Final = 100.0
HELD_MS: Final = 900.0
"""About a second; the bursts that tell the sound's age come a second apart, not exactly."""
SILENCE_MS: Final = 1500.0
"""What comes after so long without anything is judged anew."""
BURST_AT_LEAST: Final = 0.02
"""Below this amplitude there is no burst (the test card's is 0.4 at the source)."""
ROW_MS: Final = 10.0


def sane(series: Series) -> Series:
    """Leave out what cannot be drawn: infinities, and what no clock can have read."""
    return [(at, value) for at, value in series if abs(at) < MOST and abs(value) < MOST]


def picture_ages(readings: Readings) -> Series:
    """Age of each presented picture whose stamp was read."""
    return [
        (at_ms, at_ms - stamp_ms)
        for at_ms, stamp_ms in zip(
            readings.pictures.at_ms, readings.pictures.stamp_ms, strict=False
        )
        if stamp_ms is not None and math.isfinite(at_ms) and math.isfinite(stamp_ms)
    ]


def standing(ages: Series) -> Series:
    """Add, before each picture that came late, how old the one before had become by then."""
    found: Series = ages[:1]
    for (before_ms, before_age_ms), (at_ms, age_ms) in pairwise(ages):
        if at_ms - before_ms >= STALL_MS:
            found.append((at_ms, before_age_ms + at_ms - before_ms))
        found.append((at_ms, age_ms))
    return found


def sound_ages(readings: Readings, expected_ms: float | None) -> Series:
    """Age of each second's burst when it begins to be heard.

    A burst does not say of which second it is: of all that fit, the age next to `expected_ms` is
    taken (the cell's median), else the least.
    """
    ages: Series = []
    for heard_ms in _onsets(readings.sound):
        age_ms = heard_ms % 1000.0
        if expected_ms is not None and abs(expected_ms) < MOST:
            age_ms += 1000.0 * round((expected_ms - age_ms) / 1000.0)
        ages.append((heard_ms, age_ms))
    return ages


def skews(pictures: Series, sounds: Series) -> Series:
    """Sound's age less the age of the picture that stands when it is heard; above 0: sound late."""
    times = [at_ms for at_ms, _ in pictures]
    found: Series = []
    for at_ms, age_ms in sounds:
        index = bisect_left(times, at_ms)
        near = pictures[max(0, index - 1) : index + 1]
        if near and min(abs(at_ms - one) for one, _ in near) <= SILENCE_MS:
            found.append((at_ms, age_ms - near[0][1]))
    return found


def within(series: Series, figures: Figures) -> Series:
    return [(at_ms, value) for at_ms, value in series if figures.from_ms <= at_ms <= figures.to_ms]


def late_pictures_per_s(readings: Readings, figures: Figures) -> float | None:
    """Pictures more than `LATE_MS` older than the youngest; None without a readable one."""
    ages = [age_ms for _, age_ms in within(picture_ages(readings), figures)]
    seconds = (figures.to_ms - figures.from_ms) / 1000.0
    if not ages or not seconds > 0:
        return None
    return sum(age_ms > min(ages) + LATE_MS for age_ms in ages) / seconds


def picture_stalls_per_s(readings: Readings, figures: Figures) -> float | None:
    """How often one picture stood for `STALL_MS` or longer; None without any picture."""
    shown = [at for at in readings.pictures.at_ms if figures.from_ms <= at <= figures.to_ms]
    seconds = (figures.to_ms - figures.from_ms) / 1000.0
    if not shown or not seconds > 0:
        return None
    times = [*shown, figures.to_ms]
    return sum(after - one >= STALL_MS for one, after in pairwise(times)) / seconds


def recovery_ms(series: Series, began_ms: float, at_ms: float, next_ms: float) -> float | None:
    """From `at_ms` until the age is as it was before the changes, and stays so for a second.

    As it was: at most `RECOVERED_MS` above the median before `began_ms`. None when that is not
    reached before `next_ms`, or when there was nothing before.
    """
    before = [value for when_ms, value in series if when_ms < began_ms]
    if not before:
        return None
    limit_ms = median(before) + RECOVERED_MS
    since: float | None = None
    last_ms = at_ms
    for when_ms, value in series:
        if not at_ms <= when_ms <= next_ms:
            continue
        if value > limit_ms or when_ms - last_ms > SILENCE_MS:
            since = None
        if value <= limit_ms:
            since = when_ms if since is None else since
            if when_ms - since >= HELD_MS:
                return since - at_ms
        last_ms = when_ms
    return None


def thinned(series: Series, most: int) -> Series:
    """At most about `most` points: each stretch's ends and extremes, so no peak goes."""
    if len(series) <= most:
        return series
    size = math.ceil(len(series) / max(1, most // 4))
    kept: Series = []
    for begin in range(0, len(series), size):
        places = range(begin, min(begin + size, len(series)))
        least = min(places, key=lambda place: series[place][1])
        greatest = max(places, key=lambda place: series[place][1])
        kept += [series[place] for place in sorted({places[0], least, greatest, places[-1]})]
    return kept


def _onsets(sound: Sound) -> Sequence[float]:
    """When each burst begins, to a fraction of a row: the row it begins in is filled in part."""
    rows = [
        (start_ms, burst)
        for start_ms, burst in zip(sound.start_ms, sound.burst, strict=False)
        if math.isfinite(start_ms) and math.isfinite(burst)
    ]
    loudest = sorted(burst for _, burst in rows)[-(len(rows) // 50 + 1) :]
    full = median(loudest) if loudest else 0.0
    if full < BURST_AT_LEAST:
        return []
    found: list[float] = []
    for (before_ms, before), (start_ms, burst) in pairwise(rows):
        rises = before < full / 2 <= burst
        if rises and (not found or start_ms - found[-1] > 500.0):
            missing = 1.0 - min(1.0, burst / full) - min(1.0, max(0.0, before / full))
            found.append(min(start_ms, before_ms + ROW_MS) + ROW_MS * missing)
    return found
