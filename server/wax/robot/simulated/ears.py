"""How sound from one direction reaches two ears on a round head (pure).

The model of Brown and Duda (IEEE Transactions on Speech and Audio Processing 6, 1998): the path
around a sphere gives the delay, and a filter with one pole and one zero gives the head shadow.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from wax.capture.source import BLOCK_SAMPLES, SAMPLE_RATE_HZ

if TYPE_CHECKING:
    from numpy.typing import NDArray

HEAD_RADIUS_M: Final = 0.0875
SPEED_OF_SOUND_MPS: Final = 343.0
_AXES_RAD: Final = (math.pi / 2, -math.pi / 2)
"""The directions of the left and the right ear, counted from straight ahead to the left."""
_DARKEST: Final = 0.1
_DARKEST_RAD: Final = math.radians(150.0)
"""The shadow is deepest here, not directly behind, where the paths around both sides meet."""

_POLE: Final = math.exp(-2.0 * SPEED_OF_SOUND_MPS / HEAD_RADIUS_M / SAMPLE_RATE_HZ)
_LOW_PASS: Final = (1.0 - _POLE) * _POLE ** np.arange(96)
_PAST: Final = 128
"""Samples of history: more than the longest delay, 33, plus the filter's length."""
_AHEAD: Final = 2
"""Interpolation uses this many following samples."""


def delay_samples(bearing_rad: float) -> tuple[float, float]:
    """Return each ear's delay relative to the head's nearest point, left first.

    `bearing_rad` is counted from straight ahead to the left.
    """
    scale = HEAD_RADIUS_M / SPEED_OF_SOUND_MPS * SAMPLE_RATE_HZ
    left, right = (_off_axis(bearing_rad, axis) for axis in _AXES_RAD)
    return scale * _way(left), scale * _way(right)


def brightness(bearing_rad: float) -> tuple[float, float]:
    """Return the gain of high tones at each ear, 2 at the side, 0.1 in shadow; low tones have 1."""
    left, right = (_off_axis(bearing_rad, axis) for axis in _AXES_RAD)
    return _gain(left), _gain(right)


def _off_axis(bearing_rad: float, axis_rad: float) -> float:
    return abs(math.remainder(bearing_rad - axis_rad, math.tau))


def _way(off_rad: float) -> float:
    """Return the path to an ear beyond the head's nearest point, in radii."""
    if off_rad < math.pi / 2:
        return 1.0 - math.cos(off_rad)
    return 1.0 + off_rad - math.pi / 2


def _gain(off_rad: float) -> float:
    half = _DARKEST / 2.0
    return (1.0 + half) + (1.0 - half) * math.cos(off_rad * math.pi / _DARKEST_RAD)


class Ears:
    """Hears one sound after it has reached the head; each block joins the last without a click."""

    def __init__(self) -> None:
        self._past = np.zeros(_PAST)
        self._bearing_rad: float | None = None

    def hear(self, sound: NDArray[np.float64], bearing_rad: float) -> NDArray[np.float64]:
        """Return the next `BLOCK_SAMPLES` as ``(n, 2)``, the left ear first.

        `bearing_rad` is the sound's direction at the end of the block, counted from straight ahead
        to the left; it is interpolated from the last one.
        """
        before_rad = bearing_rad if self._bearing_rad is None else self._bearing_rad
        self._bearing_rad = bearing_rad
        joined = np.concatenate((self._past, sound))
        self._past = joined[-_PAST:]
        low = np.convolve(joined, _LOW_PASS)[: len(joined)]
        glide = np.arange(1, BLOCK_SAMPLES + 1) / BLOCK_SAMPLES
        ears = zip(
            delay_samples(before_rad),
            delay_samples(bearing_rad),
            brightness(before_rad),
            brightness(bearing_rad),
            strict=True,
        )
        heard = []
        for late, later, bright, brighter in ears:
            times = _PAST - _AHEAD + np.arange(BLOCK_SAMPLES) - (late + (later - late) * glide)
            high = bright + (brighter - bright) * glide
            heard.append(_between(low, times) * (1.0 - high) + _between(joined, times) * high)
        return np.column_stack(heard)


def _between(samples: NDArray[np.float64], times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Interpolate between samples by a Catmull-Rom spline through four of them."""
    at = np.floor(times).astype(np.intp)
    t = times - at
    a, b, c, d = (samples[at + shift] for shift in (-1, 0, 1, 2))
    return np.asarray(
        b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)))
    )
