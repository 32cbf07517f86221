"""Packets on the wire: how large they are, and the rates of sound and picture with headers."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from wax.congestion.allocation import SoundEncoding, Step

UDP_IP_BYTES: Final = 28
"""IPv4 and UDP headers; every datagram costs them (RFC 791, RFC 768)."""
TCP_IP_BYTES: Final = 52
"""IPv4 and TCP headers with timestamps (RFC 791, RFC 9293, RFC 7323)."""
_HEADER_BYTES: Final = UDP_IP_BYTES + 32
"""Added to the payload: IP, UDP, 12 of RTP, about 10 of its extensions, 10 of the SRTP tag."""
_MAX_SERIALIZATION_S: Final = 0.030
"""Longest serialization time of a packet, which delays the sound behind it: about one sound
packet's length."""
MIN_PAYLOAD_BYTES: Final = 200
"""A third of any smaller packet would be headers."""
MAX_PAYLOAD_BYTES: Final = 1180
"""Fits any tunnel with all headers: IPv6 guarantees 1280 (RFC 8200, 5)."""
_LAYER_SHARE: Final = 0.6
"""The fraction of the bit rate that remains without the highest layer, as encoders are set up."""
_BLOCK_BYTES: Final = 4
"""The header of each earlier unit in a packet; that of the newest is one byte (RFC 2198, 3)."""


def payload_bytes(rate_bps: float, most_bytes: int = MAX_PAYLOAD_BYTES) -> int:
    """Return the largest payload, 200 to `most_bytes`, that takes at most 30 ms to send."""
    fitting_bytes = int(rate_bps * _MAX_SERIALIZATION_S / 8) - _HEADER_BYTES
    return max(min(fitting_bytes, most_bytes, MAX_PAYLOAD_BYTES), MIN_PAYLOAD_BYTES)


def sound_bps(encoding: SoundEncoding, redundancy: int) -> float:
    """Return the rate of an encoding with this many earlier units in each packet."""
    again_bytes = _BLOCK_BYTES * redundancy + 1 if redundancy else 0
    packets_per_s = 1000 / encoding.mu_ms
    headers_bps = packets_per_s * (_HEADER_BYTES + again_bytes) * 8
    return encoding.bitrate_bps * (1 + redundancy) + headers_bps


def picture_bps(step: Step, cut: int, rate_bps: float) -> float:
    """Return the rate of a step without its `cut` highest layers, on a link of `rate_bps`."""
    fps = step.fps * 0.5**cut
    bitrate_bps = step.bitrate_bps * math.pow(_LAYER_SHARE, cut)
    packets = math.ceil(bitrate_bps / fps / 8 / payload_bytes(rate_bps))
    return bitrate_bps + fps * packets * _HEADER_BYTES * 8
