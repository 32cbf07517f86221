"""Lips against voice: what the thesis's judges looked at, by correlating opening with loudness.

A picture counts once, at the moment when it was presented, and is compared with the voice that is
heard then. So the lag is the voice's age less the picture's, exactly what the test card's skew is,
at any frame rate. What a viewer sees comes half an interval later still, because a picture stands
until the next; holding each picture would take that off the lag (17 ms at 30 pictures a second,
half a second at one) and make the two disagree.

How good the film is as a ruler, with pictures up to 20 ms early or late, a fifth of them lost and
gaps in the sound (95 % of several hundred simulated cells of 12 s, then the worst): within 4 and
10 ms at 30 pictures a second, 9 and 25 at 5, 17 and 120 at one. At one picture a second 12 s are
too short: a tenth gets no answer, and one in a hundred voices that are not the lips' own is
believed (at 5 one in 400, at 30 none); over 30 s it is within 12 and 40 ms.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from e2e.delay.talking_head.loudness import loudness, smooth

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from e2e.delay.readings import Pictures, Readings, Sound

FARTHEST_MS: Final = 1500.0
"""A lag beyond it, to either side, is not found."""

_BLOCK_MS: Final = 10.0
_GAP_MS: Final = 25.0
"""Blocks of sound that are farther apart than this have something unknown between them."""

_HEARD_SHARE: Final = 0.5
"""At a lag at which less of the pictures has its sound, nothing is said."""

_LEAST_PICTURES: Final = 10
_LEAST_MOVEMENT: Final = 0.05
"""Standard deviation of the opening; that of the film is 0.3."""

_MEMORY_MS: Final = 250.0
"""Speech after so long tells something new; pictures closer than this are not independent."""

_LEAST_CORRELATION: Final = 0.3
_LEAST_DEVIATIONS: Final = 4.8
"""What the best of all lags reaches by chance, in standard deviations of Fisher's z."""


@dataclass(frozen=True, slots=True)
class LipLag:
    """Where lips and voice fit best.

    `lag_ms` is positive when the voice comes after the lips. `correlation` is that of opening and
    loudness there, `n` the number of pictures that it rests on.
    """

    lag_ms: float
    correlation: float
    n: int


def lip_lag(readings: Readings, *, from_ms: float, to_ms: float) -> LipLag | None:
    """By how much the voice comes after the lips of the pictures presented in this time (Unix).

    None when the lips hardly move, when there is no sound to them, or when they fit the voice no
    better than another's would.
    """
    at_ms, mouth = _mouths(readings.pictures, from_ms, to_ms)
    heard_ms, loud = _voice(readings.sound)
    if len(at_ms) < _LEAST_PICTURES or mouth.std() < _LEAST_MOVEMENT or not len(loud):
        return None
    steps = round(FARTHEST_MS / _BLOCK_MS) + 1
    lags_ms = np.arange(-steps, steps + 1) * _BLOCK_MS
    fits = np.full(len(lags_ms), np.nan)
    for place, lag_ms in enumerate(lags_ms):
        voice = np.interp(at_ms + lag_ms, heard_ms, loud, left=np.nan, right=np.nan)
        known = ~np.isnan(voice)
        if known.sum() >= _HEARD_SHARE * len(at_ms):
            fits[place] = _correlation(mouth[known], voice[known])
    if np.isnan(fits).all():
        return None
    best = int(np.nanargmax(fits))
    around = fits[max(best - 1, 0) : best + 2]
    if len(around) < 3 or np.isnan(around).any():
        return None  # it rises to the end of what is known: no peak
    before, fit, after = around
    voice = np.interp(at_ms + lags_ms[best], heard_ms, loud, left=np.nan, right=np.nan)
    counted_ms = at_ms[~np.isnan(voice)]
    if fit < _believable(counted_ms):
        return None
    # The peak of the parabola through the best and its neighbours.
    beside = (before - after) / (2 * (before - 2 * fit + after))
    lag_ms = float(lags_ms[best] + beside * _BLOCK_MS)
    return LipLag(lag_ms=lag_ms, correlation=float(fit), n=len(counted_ms))


def _mouths(
    pictures: Pictures, from_ms: float, to_ms: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """When each mouth was presented, and its opening."""
    mouths = [
        (at_ms, mouth)
        for at_ms, mouth in zip(pictures.at_ms, pictures.mouth, strict=True)
        if mouth is not None and from_ms <= at_ms <= to_ms
    ]
    columns = np.array(mouths, np.float64).reshape(-1, 2)
    return columns[:, 0], columns[:, 1]


def _voice(sound: Sound) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Loudness every 10 ms, and when; not a number where nothing was recorded."""
    order = np.argsort(sound.start_ms)
    middle_ms = np.array(sound.start_ms, np.float64)[order] + _BLOCK_MS / 2
    power = np.array(sound.rms, np.float64)[order] ** 2
    if len(middle_ms) < 2:
        return middle_ms[:0], power[:0]
    grid_ms = np.arange(middle_ms[0], middle_ms[-1], _BLOCK_MS)
    after = np.clip(np.searchsorted(middle_ms, grid_ms), 1, len(middle_ms) - 1)
    even = smooth(np.interp(grid_ms, middle_ms, power))
    even[middle_ms[after] - middle_ms[after - 1] > _GAP_MS] = np.nan
    return grid_ms, loudness(even)


def _correlation(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Pearson's; 0 where one of them is flat."""
    one, other = one - one.mean(), other - other.mean()
    size = math.sqrt((one @ one) * (other @ other))
    return float(one @ other) / size if size > 1e-9 else 0.0


def _believable(at_ms: NDArray[np.float64]) -> float:
    """Return the correlation below which pictures at these moments prove nothing."""
    independent = len(np.unique(at_ms // _MEMORY_MS))
    if independent < _LEAST_PICTURES:
        return math.inf
    return max(_LEAST_CORRELATION, math.tanh(_LEAST_DEVIATIONS / math.sqrt(independent - 3)))
