"""Limits a voice to the level that suits a loudspeaker in a room, and finds its pauses (pure)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from wax.voice.packet import RATE_HZ

if TYPE_CHECKING:
    from numpy.typing import NDArray

_FULL: Final = 32_768.0
CEILING: Final = round(_FULL * 10 ** (-6 / 20))
"""No sample exceeds this: 6 dB below full scale."""
_LOUD_RMS: Final = _FULL * 10 ** (-20 / 20)
"""The level of a raised voice; noise at full scale is 15 dB louder."""
_RISE_S: Final = 0.4
_QUIET_RMS: Final = _FULL * 10 ** (-55 / 20)
_HOLD: Final = RATE_HZ * 3 // 10
"""Pauses within a sentence are shorter."""


class Limiter:
    """Lowers the gain at once when sound is too loud, and raises it again slowly.

    Sound is int16 mono at 48 kHz, in pieces of shape ``(n,)``.
    """

    def __init__(self) -> None:
        self._gain = 1.0

    def limit(self, samples: NDArray[np.int16]) -> NDArray[np.int16]:
        """Return the piece with its RMS limited to −20 dB of full scale and its peaks to −6 dB."""
        if len(samples) == 0:
            return samples
        sound = samples.astype(np.float64)
        rms, peak = float(np.sqrt(np.mean(sound**2))), float(np.abs(sound).max())
        most = min(1.0, _LOUD_RMS / max(rms, 1.0), CEILING / max(peak, 1.0))
        risen = self._gain + len(samples) / RATE_HZ / _RISE_S
        before, self._gain = min(self._gain, most), min(most, risen)
        gains = np.linspace(before, self._gain, len(samples))
        return np.clip(np.round(sound * gains), -CEILING, CEILING).astype(np.int16)


class SilenceGate:
    """Decides which pieces of a voice to play: sound and the short pauses in it."""

    def __init__(self) -> None:
        self._quiet = _HOLD

    def opens(self, samples: NDArray[np.int16]) -> bool:
        """Add a piece, int16 of shape ``(n,)``; return whether to play it."""
        sound = samples.astype(np.float64)
        if len(sound) and float(np.sqrt(np.mean(sound**2))) >= _QUIET_RMS:
            self._quiet = 0
        else:
            self._quiet = min(self._quiet + len(sound), _HOLD)
        return self._quiet < _HOLD
