"""How a wall muffles sound (pure)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from wax.capture.source import SAMPLE_RATE_HZ

if TYPE_CHECKING:
    from numpy.typing import NDArray

_MUFFLE_HZ: Final = 450.0


def muffled(sound: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a sound as heard through a wall; a seamless loop stays seamless."""
    spectrum = np.fft.rfft(sound)
    tone_hz = np.fft.rfftfreq(len(sound), 1.0 / SAMPLE_RATE_HZ)
    return np.fft.irfft(spectrum / (1.0 + (tone_hz / _MUFFLE_HZ) ** 2), len(sound))
