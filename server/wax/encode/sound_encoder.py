"""The Opus encoder: blocks in, one packet per media unit out.

Packets have no in-band FEC: it restores only one lost packet of a burst, and only when libopus uses
its speech codec, which it does not at the bit rates of good links. Loss is repaired by repeating
earlier packets (RFC 2198), which does not involve the encoder or other listeners.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Final

import av
import numpy as np

from wax.capture.source import BLOCK_SAMPLES, SAMPLE_RATE_HZ
from wax.encode.encoded import EncodedSound

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from wax.capture.source import Sound
    from wax.congestion.allocation import SoundEncoding

_TIME_BASE: Final = Fraction(1, SAMPLE_RATE_HZ)

_THIN_BPS: Final = 20_000
"""Below this the speech codec is better: at 12 kbit/s a tone keeps its level to 0.01 dB instead of
0.5, with 35 dB of signal to noise instead of 26."""


class SoundEncoder:
    """Encodes 48 kHz sound with Opus, one media unit per packet, in the encoding's channels.

    Every unit begins at a whole multiple of its length, so that units of two lengths regularly end
    together, where a listener can change between them without losing a sample.
    """

    def __init__(self, encoding: SoundEncoding) -> None:
        self.unit_samples = SAMPLE_RATE_HZ * encoding.mu_ms // 1000
        self._channels = encoding.channels
        self._layout = _layout(encoding)
        self._pending: list[Sound] = []
        self._pts = 0
        self._context = _opus(encoding)

    def encode(self, block: Sound, pts: int) -> EncodedSound | None:
        """Add the block that begins at `pts`; return a packet when a media unit is full, else None.

        When `pts` jumps, an incomplete unit is dropped.
        """
        assert len(block.samples) == BLOCK_SAMPLES
        if pts != self._pts + len(self._pending) * BLOCK_SAMPLES:
            self._pending.clear()
        if not self._pending:
            if pts % self.unit_samples:
                return None
            self._pts = pts
        self._pending.append(block.with_channels(self._channels))
        if len(self._pending) * BLOCK_SAMPLES < self.unit_samples:
            return None
        unit, self._pending = self._pending, []
        return self._encoded(np.concatenate([piece.samples for piece in unit]), unit[0].captured_s)

    def _encoded(self, samples: NDArray[np.int16], captured_s: float) -> EncodedSound | None:
        frame = av.AudioFrame.from_ndarray(
            samples.reshape(1, -1), format="s16", layout=self._layout
        )
        frame.sample_rate = SAMPLE_RATE_HZ
        frame.pts = self._pts
        frame.time_base = _TIME_BASE
        parts = self._context.encode(frame)
        if not parts:
            return None
        # A packet's content is older than its unit by the codec's look-ahead: 2.5 or 6.5 ms.
        ahead = 0 if parts[0].pts is None else self._pts - parts[0].pts
        return EncodedSound(
            data=b"".join(bytes(part) for part in parts),
            pts=self._pts,
            captured_s=captured_s - ahead / SAMPLE_RATE_HZ,
            duration_samples=len(samples),
        )


def _layout(encoding: SoundEncoding) -> str:
    return "mono" if encoding.channels == 1 else "stereo"


def _opus(encoding: SoundEncoding) -> av.AudioCodecContext:
    """Make a libopus encoder.

    On a slow link a packet's size is its delay, so all have the same size there. Elsewhere sizes
    vary around the rate ("constrained"): "vbr" exceeds it by a third at 20 ms.
    """
    thin = encoding.bitrate_bps < _THIN_BPS
    context = av.CodecContext.create("libopus", "w")
    assert isinstance(context, av.AudioCodecContext)
    context.sample_rate = SAMPLE_RATE_HZ
    context.layout = _layout(encoding)
    context.format = "s16"
    context.bit_rate = encoding.bitrate_bps
    context.options = {
        "application": "audio" if thin else "lowdelay",
        "frame_duration": str(encoding.mu_ms),
        "vbr": "off" if thin else "constrained",
    }
    return context
