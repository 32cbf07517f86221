"""Chooses the packet size, so that sound does not wait long behind a packet."""

from __future__ import annotations

from typing import Final

from wax.congestion.delivery import UDP_IP_BYTES

HEADER_BYTES: Final = UDP_IP_BYTES + 32
"""Added to the payload: IP, UDP, 12 of RTP, about 10 of its extensions, 10 of the SRTP tag."""
_MAX_SERIALIZATION_S: Final = 0.030
"""Longest serialization time of a packet, for which sound behind it waits. Ours, about one packet
of sound."""
_MIN_PAYLOAD_BYTES: Final = 200
"""A third of any smaller packet would be headers."""
_MAX_PAYLOAD_BYTES: Final = 1180
"""Fits any tunnel with all headers: IPv6 guarantees 1280 (RFC 8200, 5)."""


def payload_bytes(rate_bps: float) -> int:
    """Return the largest payload that takes at most 30 ms, within 200…1180."""
    most_bytes = int(rate_bps * _MAX_SERIALIZATION_S / 8) - HEADER_BYTES
    return min(max(most_bytes, _MIN_PAYLOAD_BYTES), _MAX_PAYLOAD_BYTES)


def train_payload_bytes(rate_bps: float, size_bytes: int, packets: int) -> int:
    """Return the payload size that splits `size_bytes` into `packets`, or the smallest allowed."""
    return max(min(payload_bytes(rate_bps), -(-size_bytes // packets)), _MIN_PAYLOAD_BYTES)
