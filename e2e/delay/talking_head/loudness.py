"""How loud a voice seems, as the mouth in the film shows it and as the lips are judged by it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

EXPONENT: Final = 0.6
"""Loudness goes with sound pressure to this power (Stevens 1955), so a murmur moves lips too."""

WINDOW_S: Final = 0.03
"""Length of the Hann window; it lies evenly about its moment, so it brings no lag."""


def loudness(power: NDArray[np.float64]) -> NDArray[np.float64]:
    """Loudness of mean squares (any unit)."""
    return np.asarray(np.maximum(power, 0.0) ** (EXPONENT / 2))


def loudness_at(
    samples: NDArray[np.int16], rate_hz: int, moments_s: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Loudness of the sound about each moment; silence before and after it."""
    half = round(WINDOW_S / 2 * rate_hz)
    window = np.hanning(2 * half + 1)
    window /= window.sum()
    power = np.pad((samples / 32768.0) ** 2, half)
    begins = np.rint(moments_s * rate_hz).astype(int)
    return loudness(np.array([power[begin : begin + len(window)] @ window for begin in begins]))


def smooth(power: NDArray[np.float64]) -> NDArray[np.float64]:
    """Give 10 ms blocks the same window: three of them, the middle one counting twice."""
    return np.convolve(np.pad(power, 1, mode="edge"), [0.25, 0.5, 0.25], mode="valid")
