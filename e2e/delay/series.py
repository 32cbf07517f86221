"""What figures and plots need of the raw series: ages, skew, recovery."""

from __future__ import annotations

import math
from itertools import pairwise
from statistics import median
from typing import TYPE_CHECKING, Final

from e2e.instrument import sums
from e2e.instrument.bursts import Burst, bursts, skews_ms

if TYPE_CHECKING:
    from e2e.delay.readings import Readings

Series = list[tuple[float, float]]
"""(Unix ms, value), in the order of the times."""

STALL_MS: Final = 200.0
"""Two video MUs: where ten pictures a second are the rule, one is missing (after 5.3)."""
RECOVERED_MS: Final = 100.0
RECOVERED_FOR_MS: Final = 900.0
"""About a second; the bursts that tell the sound's age come a second apart, not exactly."""
SILENCE_MS: Final = 1500.0
"""After a gap of this length, judgement restarts."""
FRESH_MS: Final = 300.0
FULL_RATE: Final = 27.0
"""Nine tenths of the 30 pictures a second that every system is asked for."""
HELD_MS: Final = 1000.0


def picture_ages(readings: Readings) -> Series:
    """Age of each presented picture whose stamp was read."""
    return sums.picture_ages(readings.pictures)


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
    heard = bursts(readings.sound, readings.heard_counters, picture_ages(readings))
    return [(burst.heard_ms, burst.age_ms) for burst in heard]


def skews(readings: Readings) -> Series:
    """Skew at each burst, as the instrument has it; above 0 the sound comes after the picture."""
    pictures = picture_ages(readings)
    return [
        (heard_ms, skew_ms)
        for heard_ms, age_ms in sound_ages(readings)
        for skew_ms in skews_ms([Burst(heard_ms, age_ms)], pictures)
    ]


def sized(readings: Readings, least: tuple[int, int]) -> list[tuple[float, bool]]:
    """When each new picture was shown, and whether it was at least so many pixels wide and high."""
    pictures = readings.pictures
    found: list[tuple[float, bool]] = []
    before = None
    for at_ms, stamp_ms, width, height in zip(
        pictures.at_ms, pictures.stamp_ms, pictures.width, pictures.height, strict=True
    ):
        if stamp_ms is None or stamp_ms != before:
            found.append((at_ms, width >= least[0] and height >= least[1]))
        before = stamp_ms
    return found


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
            if when_ms - since >= RECOVERED_FOR_MS:
                return since - at_ms
        last_ms = when_ms
    return None


def fresh_after_ms(ages: Series, step_ms: float, end_ms: float) -> float | None:
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
