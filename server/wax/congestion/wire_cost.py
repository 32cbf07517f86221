"""The bit rates of sound and picture on the wire, with headers."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from wax.congestion.packet_size import HEADER_BYTES, payload_bytes

if TYPE_CHECKING:
    from wax.congestion.allocation import SoundEncoding, Step

_LAYER_SHARE: Final = 0.6
"""The fraction of the bit rate left without the highest layer (as the encoders are configured)."""
_BLOCK_BYTES: Final = 4
"""The header of each earlier unit in a packet; that of the newest is one byte (RFC 2198, 3)."""


def sound_bps(encoding: SoundEncoding, redundancy: int) -> float:
    """Return the rate of an encoding with this many earlier units in each packet."""
    again_bytes = _BLOCK_BYTES * redundancy + 1 if redundancy else 0
    packets_per_s = 1000 / encoding.mu_ms
    headers_bps = packets_per_s * (HEADER_BYTES + again_bytes) * 8
    return encoding.bitrate_bps * (1 + redundancy) + headers_bps


def picture_bps(step: Step, cut: int, rate_bps: float) -> float:
    """Return the rate of a step without its `cut` highest layers, on a link of `rate_bps`."""
    fps = step.fps * 0.5**cut
    bitrate_bps = step.bitrate_bps * math.pow(_LAYER_SHARE, cut)
    packets = math.ceil(bitrate_bps / fps / 8 / payload_bytes(rate_bps))
    return bitrate_bps + fps * packets * HEADER_BYTES * 8
