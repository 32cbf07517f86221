"""What the instrument makes of a clock that lies, pure."""

from __future__ import annotations

import math
import statistics
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from e2e.instrument.cards import LIE_MS, lies

if TYPE_CHECKING:
    from collections.abc import Iterable

_LEAST_LIES: Final = 4


@dataclass(frozen=True, slots=True)
class Shift:
    """How much older lies were read than the truth beside them; `n` lies, spread to a figure.

    `uncertain_ms` is the standard error of `ms`, from the lies' own spread: what the machine's
    unrest leaves open, whatever the instrument does.
    """

    ms: float
    uncertain_ms: float
    n: int


def shift(read: Iterable[tuple[float, float]]) -> Shift | None:
    """Compare the lying seconds with the honest ones about them.

    `read` are stamps as they were read, and ages. Of each lying second that has both its
    neighbours: its mean less the mean of theirs; of all these the median. None of fewer than 4.
    Means, since ages come in steps of the screen's refresh, between which a median jumps; without
    the outer tenths, since a machine that stalls makes a few pictures old.
    """
    seconds: dict[int, list[float]] = {}
    for stamp_ms, age_ms in read:
        # Both the stamp and what it would truly be must say the same.
        if lies(stamp_ms) == lies(stamp_ms + LIE_MS):
            seconds.setdefault(math.floor((stamp_ms + 500) / 1000), []).append(age_ms)
    means = {second: _mean(ages) for second, ages in seconds.items()}
    shifts = [
        mean - (means[second - 1] + means[second + 1]) / 2
        for second, mean in means.items()
        if second % 2 == 1 and second - 1 in means and second + 1 in means
    ]
    if len(shifts) < _LEAST_LIES:
        return None
    middle = statistics.median(shifts)
    # Of a normal spread: the median's standard error by way of the median absolute deviation.
    deviation = 1.4826 * statistics.median(abs(one - middle) for one in shifts)
    return Shift(middle, 1.2533 * deviation / math.sqrt(len(shifts)), len(shifts))


def _mean(ages: list[float]) -> float:
    outer = len(ages) // 10
    return statistics.fmean(sorted(ages)[outer : len(ages) - outer])


def is_clear(read: Shift, expected: float, limit: float) -> bool:
    """Tell whether it is inside or outside of the limit by two standard errors or more."""
    off = abs(abs(read.ms - expected) - limit)
    return off >= 2 * read.uncertain_ms
