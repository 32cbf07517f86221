"""Convert any sound to 48 kHz signed 16 bit, mono or stereo."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from av.audio.resampler import AudioResampler

from wax.capture.source import SAMPLE_RATE_HZ

if TYPE_CHECKING:
    from av.audio.frame import AudioFrame
    from numpy.typing import NDArray


class Resampler:
    """Converts the frames of one stream, keeping each sample's time in the stream.

    `channels` is 1 or 2; sound of more channels is mixed into as many.
    """

    def __init__(self, channels: int) -> None:
        self._shape = (-1,) if channels == 1 else (-1, channels)
        layout = "mono" if channels == 1 else "stereo"
        self._resampler = AudioResampler(format="s16", layout=layout, rate=SAMPLE_RATE_HZ)

    def feed(self, frame: AudioFrame | None) -> list[tuple[NDArray[np.int16], float]]:
        """Return pieces of n ≥ 1 samples, each with its first sample's stream time in s.

        Their shape is ``(n,)`` for one channel, ``(n, 2)`` for two. Frames need a timestamp. None
        flushes the filter, which accepts no frames afterwards.
        """
        pieces = []
        for out in self._resampler.resample(frame):
            samples = out.to_ndarray().reshape(self._shape).astype(np.int16, copy=False)
            if len(samples):
                pieces.append((samples, (out.pts or 0) / SAMPLE_RATE_HZ))
        return pieces
