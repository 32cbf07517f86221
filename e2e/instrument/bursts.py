"""How old the sound is: when the test card's bursts were heard, and which second each is of."""

from __future__ import annotations

import statistics
from bisect import bisect_left, bisect_right
from itertools import pairwise
from typing import TYPE_CHECKING, Final

from e2e.measure.ear import BLOCK_MS

if TYPE_CHECKING:
    from e2e.delay.readings import Counters, Sound

Series = list[tuple[float, float]]
"""(Unix ms, value), in the order of the times."""

_ABSENT: Final = 0.02
_PRESENT: Final = 0.1
"""A quarter of the burst's amplitude, which nothing else reaches."""

_CONTIGUOUS_MS: Final = 5.0
_LOST_MS: Final = 3000.0
"""Bursts that are farther apart are evaluated separately."""

_EARLY_MS: Final = 50.0
"""Sound cannot be heard before it is made; this much is allowed for errors."""

_NEAR_MS: Final = 2000.0
_BESIDE_MS: Final = 500.0


def onsets_ms(sound: Sound) -> list[float]:
    """Return when each burst began, Unix ms, to a fraction of a block.

    The first block holds a part of the burst; the size of that part gives the time inside the
    block. A burst whose beginning was lost, with the block before it or in concealment, is left
    out.
    """
    found = []
    for i in range(1, len(sound.burst) - 1):
        before, first, second = sound.burst[i - 1 : i + 2]
        starts = sound.start_ms[i - 1 : i + 2]
        if not before < _ABSENT <= first or second <= _PRESENT:
            continue
        if all(abs(b - a - BLOCK_MS) < _CONTIGUOUS_MS for a, b in pairwise(starts)):
            found.append(starts[1] + BLOCK_MS * (1 - min(1.0, first / second)))
    return found


def bursts(sound: Sound, counters: Counters, pictures: Series) -> Series:
    """Return the start of each burst as heard (Unix ms), and its age since its own second.

    `pictures` are moments and ages of pictures, in order.

    A burst does not say which second it is of, so its age is known except for whole seconds. From
    one burst to the next the age changes by less than half a second, so one number of whole seconds
    applies to a row of bursts: the age is at least what the jitter buffer held, and of the
    remaining ages the one nearest to the pictures' is taken.

    Residual error: where the sound is more than half a second from the picture and more than a
    second above the jitter buffer's delay, whole seconds may be missing.
    """
    found = []
    for row in _rows(onsets_ms(sound)):
        ages = [row[0] % 1000]
        for before, heard in pairwise(row):
            change = (heard - before + 500) % 1000 - 500
            ages.append(ages[-1] + change)
        whole = _whole_seconds(row, ages, counters, pictures)
        found += [(heard, age + whole) for heard, age in zip(row, ages, strict=True)]
    return found


def _rows(heard_ms: list[float]) -> list[list[float]]:
    rows: list[list[float]] = []
    for heard in heard_ms:
        if rows and heard - rows[-1][-1] < _LOST_MS:
            rows[-1].append(heard)
        else:
            rows.append([heard])
    return rows


def _whole_seconds(
    heard_ms: list[float],
    ages_ms: list[float],
    counters: Counters,
    pictures: Series,
) -> float:
    """Return what to add to the ages of a row of bursts."""
    begin, end = heard_ms[0] - _NEAR_MS, heard_ms[-1] + _NEAR_MS
    buffered = [
        held
        for at, held in zip(counters.at_ms, counters.sound_buffer_ms, strict=True)
        if held is not None and begin <= at <= end
    ]
    least = (statistics.median(buffered) if buffered else 0.0) - _EARLY_MS
    middle = statistics.median(ages_ms)
    add = 1000.0 * -((middle - least) // 1000)
    beside = [age for at, age in pictures if begin <= at <= end]
    if beside:
        beyond = statistics.median(beside) - (middle + add)
        add += 1000.0 * max(0, round(beyond / 1000))
    return add


def skews_ms(heard: Series, pictures: Series) -> list[float]:
    """Return the sound's age minus the picture's at each burst; above 0 the sound is later.

    The picture's age is the median of those presented within `_BESIDE_MS` of the burst; without
    any, the burst is left out.
    """
    at_ms = [at for at, _ in pictures]
    skews = []
    for heard_ms, age_ms in heard:
        first = bisect_left(at_ms, heard_ms - _BESIDE_MS)
        end = bisect_right(at_ms, heard_ms + _BESIDE_MS)
        if first < end:
            skews.append(age_ms - statistics.median(age for _, age in pictures[first:end]))
    return skews
