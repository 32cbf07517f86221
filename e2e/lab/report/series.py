"""What the plots and some figures need of the raw series: ages, skew, gaps, recovery."""

from __future__ import annotations

import math
from itertools import pairwise
from statistics import median
from typing import TYPE_CHECKING, Final

from e2e.lab.instrument import sums
from e2e.lab.instrument.bursts import Burst, bursts, skews_ms
from e2e.lab.readings import Counters, Sound

if TYPE_CHECKING:
    from e2e.lab.figures import Figures
    from e2e.lab.readings import Readings

Series = list[tuple[float, float]]
"""(Unix ms, value), in the order of the times."""

MOST: Final = 1e9
"""Eleven days in ms."""
MOST_UNIX_MS: Final = 1e15
LATE_MS: Final = 100.0
"""One video MU: a picture this much older than the cell's youngest is late (after 5.2.1.1)."""
STALL_MS: Final = 200.0
"""Two video MUs: where ten pictures a second are the rule, one is missing (after 5.3)."""
RECOVERED_MS: Final = 100.0
HELD_MS: Final = 900.0
"""About a second; the bursts that tell the sound's age come a second apart, not exactly."""
SILENCE_MS: Final = 1500.0
"""What comes after so long without anything is judged anew."""


def sane(series: Series) -> Series:
    """Leave out what cannot be drawn: infinities, and what no clock can have read."""
    return [(at, value) for at, value in series if abs(at) < MOST and abs(value) < MOST]


def picture_ages(readings: Readings) -> Series:
    """Age of each presented picture whose stamp was read."""
    return [
        (at_ms, age_ms)
        for at_ms, age_ms in sums.picture_ages(readings.pictures)
        if _is_time(at_ms) and _is_time(age_ms)
    ]


def standing(ages: Series) -> Series:
    """Add, before each picture that came late, how old the one before had become by then."""
    found: Series = ages[:1]
    for (before_ms, before_age_ms), (at_ms, age_ms) in pairwise(ages):
        if at_ms - before_ms >= STALL_MS:
            found.append((at_ms, before_age_ms + at_ms - before_ms))
        found.append((at_ms, age_ms))
    return found


def sound_ages(readings: Readings) -> Series:
    """Age of each second's burst when it begins to be heard, as the instrument finds it."""
    sound = [
        (start_ms, burst)
        for start_ms, burst in zip(readings.sound.start_ms, readings.sound.burst, strict=False)
        if _is_time(start_ms) and _is_time(burst)
    ]
    held = [
        (at_ms, ms)
        for at_ms, ms in zip(
            readings.counters.at_ms, readings.counters.sound_buffer_ms, strict=False
        )
        if ms is not None and _is_time(at_ms) and _is_time(ms)
    ]
    heard = bursts(
        Sound(start_ms=[one for one, _ in sound], burst=[one for _, one in sound]),
        Counters(at_ms=[one for one, _ in held], sound_buffer_ms=[one for _, one in held]),
        picture_ages(readings),
    )
    return [(burst.heard_ms, burst.age_ms) for burst in heard]


def skews(pictures: Series, sounds: Series) -> Series:
    """Skew at each burst, as the instrument has it; above 0 the sound comes after the picture."""
    return [
        (heard_ms, skew_ms)
        for heard_ms, age_ms in sounds
        for skew_ms in skews_ms([Burst(heard_ms, age_ms)], pictures)
    ]


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
    new = sums.shown_ms(readings.pictures)
    shown = [at for at in new if figures.from_ms <= at <= figures.to_ms]
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


def _is_time(value: float) -> bool:
    return abs(value) < MOST_UNIX_MS
