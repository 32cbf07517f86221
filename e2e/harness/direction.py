"""Where a sound comes from, by the difference between two ears alone (pure)."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from wax.capture.source import BLOCK_SAMPLES, SAMPLE_RATE_HZ
from wax.robot.simulated.ears import Ears

if TYPE_CHECKING:
    from numpy.typing import NDArray

_LOW_HZ: Final = 150.0
_HIGH_HZ: Final = 1500.0
"""Above this a period is shorter than the way around the head, and the delay is ambiguous."""
_DELAYS_S: Final = np.linspace(-0.001, 0.001, 201)
"""No sound needs longer around a head."""
_LEARNT_DEG: Final = tuple(range(-90, 91, 10))
_LEARNT_BLOCKS: Final = 40


def lateral_deg(heard: NDArray[Any]) -> float | None:
    """Return how far to the left of the median plane a sound comes from, −90 to 90 degrees.

    `heard` is ``(n, 2)`` at 48 kHz, the left ear first; front and back are one, as for any two ears
    that do not move. None where there is nothing to hear.
    """
    later_s = interaural_delay_s(heard)
    if later_s is None:
        return None
    return float(np.interp(later_s, _known_delays_s(), _LEARNT_DEG))


def interaural_delay_s(heard: NDArray[Any]) -> float | None:
    """Return how much later the right ear hears than the left; None where neither hears."""
    spectrum = np.fft.rfft(heard.astype(np.float64), 2 * len(heard), axis=0)
    tones_hz = np.fft.rfftfreq(2 * len(heard), 1.0 / SAMPLE_RATE_HZ)
    in_band = (tones_hz >= _LOW_HZ) & (tones_hz <= _HIGH_HZ)
    cross = spectrum[in_band, 1] * np.conj(spectrum[in_band, 0])
    if not np.abs(cross).any():
        return None
    # Half-way whitened: neither the loudest tone alone decides, nor the noise between tones.
    cross /= np.sqrt(np.abs(cross)) + 1e-9
    likeness = cross @ np.exp(2j * np.pi * np.outer(tones_hz[in_band], _DELAYS_S))
    return float(_DELAYS_S[np.argmax(likeness.real)])


@cache
def _known_delays_s() -> tuple[float, ...]:
    """Return the delays from `_LEARNT_DEG`, as whoever has these ears has learnt them."""
    noise = np.random.default_rng(1).normal(0.0, 1.0, (_LEARNT_BLOCKS, BLOCK_SAMPLES))
    found = []
    for bearing_deg in _LEARNT_DEG:
        ears = Ears()
        heard = np.concatenate([ears.hear(block, np.radians(bearing_deg)) for block in noise])
        later_s = interaural_delay_s(heard)
        assert later_s is not None
        found.append(later_s)
    return tuple(found)
