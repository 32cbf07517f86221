"""The Opus encoder: 20 ms blocks in, one packet per media unit out, without a seam."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Final

import av
import numpy as np

from wax.media.encoded import EncodedSound
from wax.media.source import BLOCK_SAMPLES, SAMPLE_RATE_HZ

if TYPE_CHECKING:
    from wax.media.source import Sound

_RESEAM_SAMPLES: Final = SAMPLE_RATE_HZ // 20
"""The RTP clock counts samples; it jumps only when capture time has left it by 50 ms."""


class SoundEncoder:
    """Encodes 48 kHz mono sound with Opus, `mu_ms` (20, 40 or 60) a packet.

    An RTP time that is off by one sample makes a browser conceal, so `pts` counts samples and
    capture time only anchors it.
    """

    def __init__(self, *, bitrate_bps: int, mu_ms: int) -> None:
        self._blocks_per_packet = mu_ms // 20
        self._pending: list[Sound] = []
        self._next_pts: int | None = None
        self._context = _opus(bitrate_bps, mu_ms)

    def encode(self, block: Sound) -> EncodedSound | None:
        """Take one block of 960 samples; a packet when a media unit is full, else None."""
        assert len(block.samples) == BLOCK_SAMPLES
        self._pending.append(block)
        if len(self._pending) < self._blocks_per_packet:
            return None
        unit, self._pending = self._pending, []
        samples = np.concatenate([piece.samples for piece in unit])
        captured_s = unit[0].captured_s
        pts = self._seamless(round(captured_s * SAMPLE_RATE_HZ), len(samples))
        frame = av.AudioFrame.from_ndarray(samples.reshape(1, -1), format="s16", layout="mono")
        frame.sample_rate = SAMPLE_RATE_HZ
        frame.pts = pts
        frame.time_base = Fraction(1, SAMPLE_RATE_HZ)
        data = b"".join(bytes(packet) for packet in self._context.encode(frame))
        if not data:
            return None
        packet = av.Packet(data)
        packet.pts = pts
        packet.time_base = Fraction(1, SAMPLE_RATE_HZ)
        return EncodedSound(packet=packet, captured_s=captured_s, duration_samples=len(samples))

    def _seamless(self, captured_pts: int, duration: int) -> int:
        pts = self._next_pts
        if pts is None or abs(captured_pts - pts) > _RESEAM_SAMPLES:
            pts = captured_pts if pts is None else max(captured_pts, pts)
        self._next_pts = pts + duration
        return pts


def _opus(bitrate_bps: int, mu_ms: int) -> av.AudioCodecContext:
    context = av.CodecContext.create("libopus", "w")
    assert isinstance(context, av.AudioCodecContext)
    context.sample_rate = SAMPLE_RATE_HZ
    context.layout = "mono"
    context.format = "s16"
    context.bit_rate = bitrate_bps
    context.options = {"application": "lowdelay", "frame_duration": str(mu_ms), "vbr": "on"}
    return context
