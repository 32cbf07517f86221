"""A voice for tests: tones in packets as a browser would send them."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

import av
import numpy as np

from wax.voice.packet import RATE_HZ, VoicePacket

if TYPE_CHECKING:
    from numpy.typing import NDArray


def tone(hz: float, seconds: float, *, level: float = 0.1) -> NDArray[np.int16]:
    """Return a tone at 48 kHz, its level a fraction of full scale."""
    at_s = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    return np.asarray(np.round(32_767 * level * np.sin(2 * np.pi * hz * at_s)), np.int16)


def packets(
    sound: NDArray[np.int16], *, unit_ms: int = 20, bitrate_bps: int = 24_000, source: int = 1
) -> list[VoicePacket]:
    """Encode the sound into Opus packets."""
    encoder = av.CodecContext.create("libopus", "w")
    assert isinstance(encoder, av.AudioCodecContext)
    encoder.sample_rate, encoder.layout, encoder.format = RATE_HZ, "mono", "s16"
    encoder.bit_rate = bitrate_bps
    encoder.options = {"application": "voip", "frame_duration": str(unit_ms)}
    unit = RATE_HZ * unit_ms // 1000
    found: list[VoicePacket] = []
    for begin in range(0, len(sound) - unit + 1, unit):
        piece = sound[begin : begin + unit].reshape(1, -1)
        frame = av.AudioFrame.from_ndarray(piece, format="s16", layout="mono")
        frame.sample_rate, frame.pts, frame.time_base = RATE_HZ, begin, Fraction(1, RATE_HZ)
        for packet in encoder.encode(frame):
            found.append(VoicePacket(source, len(found) * unit, unit, bytes(packet)))
    return found


def loudest_hz(samples: NDArray[np.int16]) -> float:
    """Return the frequency of the loudest tone."""
    spectrum = np.abs(np.fft.rfft(samples * np.hanning(len(samples))))
    return float(np.argmax(spectrum)) * RATE_HZ / len(samples)
