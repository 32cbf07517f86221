"""Conceals lost packets of a voice by repeating its last period, fading out (pure).

FFmpeg's decoder does not expose libopus's own concealment. The method is that of G.711's
Appendix I, with a fade of 60 ms.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from wax.voice.packet import RATE_HZ

if TYPE_CHECKING:
    from numpy.typing import NDArray

_SHORTEST: Final = RATE_HZ // 400
_LONGEST: Final = RATE_HZ // 66
"""The shortest and longest period of a human voice, 400 and 66 Hz."""
_COARSE: Final = 8
"""Periods are compared at 6 kHz, which takes a 64th of the work."""
_FADE: Final = RATE_HZ * 60 // 1000
_JOIN: Final = RATE_HZ * 5 // 1000


class Concealer:
    """Tracks what is played, int16 mono at 48 kHz in pieces of shape ``(n,)``."""

    def __init__(self) -> None:
        self._kept = np.zeros(3 * _LONGEST, np.float64)
        self._period: NDArray[np.float64] | None = None
        self._concealed = 0

    def join(self, samples: NDArray[np.int16]) -> NDArray[np.int16]:
        """Return received samples, cross-faded with any concealment before them."""
        result = samples
        if self._concealed:
            length = min(_JOIN, len(samples))
            rise = np.arange(1, length + 1) / (length + 1)
            tail = self._synthesize(length)
            result = samples.copy()
            result[:length] = np.round(tail * (1 - rise) + samples[:length] * rise)
        self._period, self._concealed = None, 0
        self._keep(samples)
        return result

    def conceal(self, count: int) -> NDArray[np.int16]:
        """Return `count` samples to replace lost ones; after 60 ms they are silent."""
        return np.round(self._synthesize(count)).astype(np.int16)

    def reset(self) -> None:
        """Forget what was played, because what follows is unrelated to it."""
        self._kept[:] = 0
        self._period, self._concealed = None, 0

    def _synthesize(self, count: int) -> NDArray[np.float64]:
        if self._period is None:
            self._period = self._kept[-_period_of(self._kept) :].copy()
        places = np.arange(self._concealed, self._concealed + count)
        self._concealed += count
        fade = np.clip(1 - places / _FADE, 0, 1)
        return np.asarray(self._period[places % len(self._period)] * fade)

    def _keep(self, samples: NDArray[np.int16]) -> None:
        new = samples[-len(self._kept) :].astype(np.float64)
        self._kept = np.concatenate((self._kept[len(new) :], new))


def _period_of(samples: NDArray[np.float64]) -> int:
    """Return the lag in samples at which the end correlates best with what precedes it."""
    coarse = samples[: len(samples) // _COARSE * _COARSE].reshape(-1, _COARSE).mean(axis=1)
    window = len(coarse) // 3
    end = coarse[-window:]
    lags = range(_SHORTEST // _COARSE, min(_LONGEST // _COARSE, len(coarse) - window) + 1)
    size = float(np.linalg.norm(end)) + 1e-9

    def likeness(lag: int) -> float:
        before = coarse[len(coarse) - window - lag : len(coarse) - lag]
        return float(end @ before) / (size * (float(np.linalg.norm(before)) + 1e-9))

    return max(lags, key=likeness) * _COARSE
