"""Makes up what is lost of a voice: its last period again, fading out (pure).

What libopus itself has for that, FFmpeg's decoder does not offer. The method is that of G.711's
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
"""The periods of people's voices, 66 to 400 Hz."""
_COARSE: Final = 8
"""Periods are compared at 6 kHz, which is a 64th of the work."""
_FADE: Final = RATE_HZ * 60 // 1000
_JOIN: Final = RATE_HZ * 5 // 1000


class Concealer:
    """Follows what is played, int16 mono at 48 kHz in pieces of shape ``(n,)``."""

    def __init__(self) -> None:
        self._kept = np.zeros(3 * _LONGEST, np.float64)
        self._period: NDArray[np.float64] | None = None
        self._made_up = 0

    def played(self, samples: NDArray[np.int16]) -> NDArray[np.int16]:
        """Return what was received, joined without a click to what was concealed before it."""
        result = samples
        if self._made_up:
            length = min(_JOIN, len(samples))
            rise = np.arange(1, length + 1) / (length + 1)
            tail = self._made(length)
            result = samples.copy()
            result[:length] = np.round(tail * (1 - rise) + samples[:length] * rise)
        self._period, self._made_up = None, 0
        self._keep(samples)
        return result

    def make_up(self, count: int) -> NDArray[np.int16]:
        """Return `count` samples in place of lost ones; after 60 ms they are silence."""
        return np.round(self._made(count)).astype(np.int16)

    def reset(self) -> None:
        """Forget what was played: what comes next does not go on from it."""
        self._kept[:] = 0
        self._period, self._made_up = None, 0

    def _made(self, count: int) -> NDArray[np.float64]:
        if self._period is None:
            self._period = self._kept[-_period_of(self._kept) :].copy()
        places = np.arange(self._made_up, self._made_up + count)
        self._made_up += count
        fade = np.clip(1 - places / _FADE, 0, 1)
        return np.asarray(self._period[places % len(self._period)] * fade)

    def _keep(self, samples: NDArray[np.int16]) -> None:
        new = samples[-len(self._kept) :].astype(np.float64)
        self._kept = np.concatenate((self._kept[len(new) :], new))


def _period_of(samples: NDArray[np.float64]) -> int:
    """Return after how many samples the end of these is most like what was before."""
    coarse = samples[: len(samples) // _COARSE * _COARSE].reshape(-1, _COARSE).mean(axis=1)
    window = len(coarse) // 3
    end = coarse[-window:]
    lags = range(_SHORTEST // _COARSE, min(_LONGEST // _COARSE, len(coarse) - window) + 1)
    size = float(np.linalg.norm(end)) + 1e-9

    def likeness(lag: int) -> float:
        before = coarse[len(coarse) - window - lag : len(coarse) - lag]
        return float(end @ before) / (size * (float(np.linalg.norm(before)) + 1e-9))

    return max(lags, key=likeness) * _COARSE
