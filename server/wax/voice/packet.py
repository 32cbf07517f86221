"""A packet of somebody's voice, and how much sound it holds (pure; RFC 6716, 3.1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from wax.errors import ProtocolError

RATE_HZ: Final = 48_000
"""The rate of Opus's RTP clock and of all sound inside WAX (RFC 7587, 4.1)."""

MAX_SAMPLES: Final = RATE_HZ * 120 // 1000
MAX_BYTES: Final = 1276 * 3
"""Three frames of the greatest length, which is the most for 60 ms of sound."""

_SPEECH_SAMPLES: Final = (480, 960, 1920, 2880)
_MUSIC_SAMPLES: Final = (120, 240, 480, 960)


@dataclass(frozen=True, slots=True)
class VoicePacket:
    """One Opus packet: `samples` at 48 kHz, from the RTP timestamp `timestamp` (32 bits).

    `source` is its SSRC; timestamps of different sources are unrelated.
    """

    source: int
    timestamp: int
    samples: int
    payload: bytes


def opus_samples(payload: bytes) -> int:
    """Return how many samples at 48 kHz a packet of Opus decodes to; raises `ProtocolError`."""
    if not 0 < len(payload) <= MAX_BYTES:
        raise ProtocolError(f"{len(payload)} bytes are no packet of Opus")
    config, code = payload[0] >> 3, payload[0] & 3
    if config < 12:
        each = _SPEECH_SAMPLES[config % 4]
    elif config < 16:
        each = _SPEECH_SAMPLES[config % 2]
    else:
        each = _MUSIC_SAMPLES[config % 4]
    if code == 3 and len(payload) < 2:
        raise ProtocolError("a packet of Opus without the number of its frames")
    frames = payload[1] & 0x3F if code == 3 else 2 if code else 1
    if not 0 < frames * each <= MAX_SAMPLES:
        raise ProtocolError(f"a packet of Opus of {frames} frames of {each} samples")
    return frames * each
