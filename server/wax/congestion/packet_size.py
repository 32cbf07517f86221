"""How large packets may be, so that sound does not wait long behind one."""

from __future__ import annotations

from typing import Final

from wax.congestion.delivery import UDP_IP_BYTES

HEADER_BYTES: Final = UDP_IP_BYTES + 32
"""Beside its payload: IP, UDP, 12 of RTP, about 10 of its extensions, 10 of the SRTP tag."""

_LONGEST_S: Final = 0.030
_LEAST_BYTES: Final = 200
_MOST_BYTES: Final = 1180


def payload_bytes(rate_bps: float) -> int:
    """Return the largest payload that takes at most 30 ms, within 200…1180."""
    return min(max(int(rate_bps * _LONGEST_S / 8) - HEADER_BYTES, _LEAST_BYTES), _MOST_BYTES)


def train_payload_bytes(rate_bps: float, size_bytes: int, packets: int) -> int:
    """Return a payload that makes so many packets of `size_bytes`, where they are not too small."""
    return max(min(payload_bytes(rate_bps), -(-size_bytes // packets)), _LEAST_BYTES)
