"""Parses the voice packets that a page sends (RFC 3550, 5.1, and RFC 7587). Pure."""

from __future__ import annotations

from struct import unpack_from
from typing import Final

from wax.errors import ProtocolError
from wax.voice.packet import VoicePacket, opus_samples

_FIXED_BYTES: Final = 12


def read(data: bytes, payload_type: int) -> VoicePacket | None:
    """Parse a decrypted RTP packet; None if its payload type is not `payload_type`, Opus.

    Raises `ProtocolError`.
    """
    if len(data) < _FIXED_BYTES or data[0] >> 6 != 2:
        raise ProtocolError("not a packet of RTP")
    if data[1] & 0x7F != payload_type:
        return None
    _sequence, timestamp, source = unpack_from("!HLL", data, 2)
    begin = _FIXED_BYTES + 4 * (data[0] & 0x0F)
    if data[0] & 0x10:
        if len(data) < begin + 4:
            raise ProtocolError("a packet of RTP that ends in its header")
        begin += 4 + 4 * int.from_bytes(data[begin + 2 : begin + 4])
    end = len(data) - (data[-1] if data[0] & 0x20 else 0)
    if end <= begin:
        raise ProtocolError("a packet of RTP with nothing in it")
    payload = data[begin:end]
    return VoicePacket(source, timestamp, opus_samples(payload), payload)
