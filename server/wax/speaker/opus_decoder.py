"""Decodes a voice's Opus packets.

FFmpeg's wrapper of libopus offers neither concealment nor forward error correction, so lost packets
are concealed by `wax.voice.concealment`.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Final

import av
import numpy as np

from wax.errors import ProtocolError
from wax.voice.packet import RATE_HZ

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from wax.voice.packet import VoicePacket

_TIME_BASE: Final = Fraction(1, RATE_HZ)


class OpusDecoder:
    """Decodes the packets of one voice, in order; stereo becomes mono."""

    def __init__(self) -> None:
        context = av.CodecContext.create("libopus", "r")
        assert isinstance(context, av.AudioCodecContext)
        context.sample_rate = RATE_HZ
        context.layout = "mono"
        context.format = "s16"
        self._context = context

    def decode(self, packet: VoicePacket) -> NDArray[np.int16]:
        """Return the packet's samples, int16 mono of shape ``(n,)``; raises `ProtocolError`."""
        data = av.Packet(packet.payload)
        data.pts = packet.timestamp
        data.time_base = _TIME_BASE
        try:
            frames = self._context.decode(data)
        except av.FFmpegError as error:
            raise ProtocolError(f"a packet of Opus that cannot be decoded: {error}") from error
        pieces = [_mono(frame) for frame in frames]
        return np.concatenate(pieces) if pieces else np.zeros(0, np.int16)


def _mono(frame: av.AudioFrame) -> NDArray[np.int16]:
    channels = frame.layout.nb_channels
    samples = frame.to_ndarray().reshape(-1, channels)
    if channels == 1:
        return np.asarray(samples[:, 0], np.int16)
    return np.asarray(samples.mean(axis=1).round(), np.int16)
