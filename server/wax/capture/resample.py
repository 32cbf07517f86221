"""Convert any sound to 48 kHz mono signed 16 bit."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from av.audio.resampler import AudioResampler

from wax.capture.source import SAMPLE_RATE_HZ

if TYPE_CHECKING:
    from av.audio.frame import AudioFrame
    from numpy.typing import NDArray


class Resampler:
    """Converts the frames of one stream, keeping each sample's time in the stream."""

    def __init__(self) -> None:
        self._resampler = AudioResampler(format="s16", layout="mono", rate=SAMPLE_RATE_HZ)

    def feed(self, frame: AudioFrame | None) -> list[tuple[NDArray[np.int16], float]]:
        """Return pieces of samples ``(n,)``, n ≥ 1, each with its first sample's stream time in s.

        Frames need a timestamp. None flushes the filter, which accepts no frames afterwards.
        """
        pieces = []
        for out in self._resampler.resample(frame):
            samples = out.to_ndarray().reshape(-1).astype(np.int16, copy=False)
            if len(samples):
                pieces.append((samples, (out.pts or 0) / SAMPLE_RATE_HZ))
        return pieces
