"""Parses the header of an SRTP packet, which needs no key (pure).

RFC 3550, 5.1; RFC 3711, 3.1; RFC 8285, 4.2. Packets that are only counted are not decrypted.
"""

from __future__ import annotations

from struct import unpack_from
from typing import Final, NamedTuple

_FIXED_BYTES: Final = 12
_ONE_BYTE_HEADERS: Final = 0xBEDE


class RtpHeader(NamedTuple):
    """The fields of one packet; `transport_sequence` is None if the packet has none."""

    payload_type: int
    marker: bool
    sequence_number: int
    timestamp: int
    ssrc: int
    payload: bytes
    """Still encrypted, with SRTP's authentication tag at its end."""
    transport_sequence: int | None


def is_rtp(data: bytes) -> bool:
    """Return whether it is RTP, not RTCP, DTLS or STUN on the same port (RFC 7983, RFC 5761)."""
    return len(data) >= _FIXED_BYTES and 127 < data[0] < 192 and not 192 <= data[1] <= 223


def read(data: bytes, extension_id: int | None) -> RtpHeader | None:
    """Parse the header; None if the packet is truncated.

    `extension_id` is the negotiated ID of the transport-wide sequence number, if any.
    """
    sequence, timestamp, ssrc = unpack_from("!HLL", data, 2)
    size = _FIXED_BYTES + 4 * (data[0] & 0x0F)
    transport_sequence = None
    if data[0] & 0x10:
        if len(data) < size + 4:
            return None
        profile, words = unpack_from("!HH", data, size)
        begin, size = size + 4, size + 4 + 4 * words
        if len(data) < size:
            return None
        if profile == _ONE_BYTE_HEADERS and extension_id is not None:
            transport_sequence = _find(data, begin, size, extension_id)
    return RtpHeader(
        data[1] & 0x7F,
        data[1] >= 128,
        sequence,
        timestamp,
        ssrc,
        data[size:],
        transport_sequence,
    )


def _find(data: bytes, begin: int, end: int, extension_id: int) -> int | None:
    while begin < end:
        one = data[begin]
        if one == 0:  # padding
            begin += 1
            continue
        length = (one & 0x0F) + 1
        if one >> 4 == extension_id and length == 2 and begin + 3 <= end:
            return (data[begin + 1] << 8) | data[begin + 2]
        begin += 1 + length
    return None
