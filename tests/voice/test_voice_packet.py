"""Voice packets: their length, and what is refused."""

from __future__ import annotations

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.errors import ProtocolError
from wax.rtc import voice_packet
from wax.voice.packet import MAX_SAMPLES, opus_samples


@pytest.mark.parametrize(
    ("payload", "samples"),
    [
        (bytes([0 << 3]), 480),
        (bytes([3 << 3]), 2880),
        (bytes([1 << 3 | 1]), 1920),
        (bytes([13 << 3]), 960),
        (bytes([16 << 3]), 120),
        (bytes([31 << 3]), 960),
        (bytes([31 << 3 | 2, 1, 0]), 1920),
        (bytes([31 << 3 | 3, 6]), 5760),
        (bytes([16 << 3 | 3, 0x80 | 48]), 5760),
    ],
)
def test_lengths(payload: bytes, samples: int) -> None:
    """The first byte says how long a packet is (RFC 6716, table 2 and 3.2)."""
    assert opus_samples(payload) == samples


@pytest.mark.parametrize(
    "payload",
    [b"", bytes([31 << 3 | 3]), bytes([31 << 3 | 3, 0]), bytes([31 << 3 | 3, 7]), bytes(4000)],
)
def test_what_is_no_packet_of_opus_is_refused(payload: bytes) -> None:
    """Opus is refused if empty, without frame count, without frames, over 120 ms or too large."""
    with pytest.raises(ProtocolError):
        opus_samples(payload)


def rtp(payload: bytes, *, first: int = 0x80, kind: int = 111, more: bytes = b"") -> bytes:
    return struct.pack("!BBHLL", first, kind, 7, 960, 5) + more + payload


SPEECH = bytes([1 << 3]) + b"voice"


@pytest.mark.parametrize(
    "data",
    [
        rtp(SPEECH),
        rtp(SPEECH, kind=0x80 | 111),
        rtp(SPEECH, first=0x82, more=bytes(8)),
        rtp(SPEECH, first=0x90, more=struct.pack("!HHL", 0xBEDE, 1, 0)),
        rtp(SPEECH + bytes((0, 0, 3)), first=0xA0),
    ],
    ids=["plain", "marked", "mixed", "extended", "padded"],
)
def test_the_payload_is_found(data: bytes) -> None:
    """The payload is found after contributing sources and extensions, and before the padding."""
    packet = voice_packet.read(data, 111)
    assert packet is not None
    assert (packet.source, packet.timestamp, packet.samples) == (5, 960, 960)
    assert packet.payload == SPEECH


def test_another_kind_of_packet_is_not_ours() -> None:
    """Comfort noise, telephone events and redundant sound are ignored."""
    assert voice_packet.read(rtp(SPEECH, kind=13), 111) is None


@pytest.mark.parametrize(
    "data",
    [
        b"",
        rtp(b""),
        rtp(SPEECH, first=0x00),
        rtp(b"", first=0x90, more=b"\xbe"),
        rtp(b"", first=0x90, more=struct.pack("!HH", 0xBEDE, 900)),
        rtp(b"\xff", first=0xA0),
    ],
)
def test_what_is_cut_off_is_refused(data: bytes) -> None:
    """A packet that lacks what its header announces is refused."""
    with pytest.raises(ProtocolError):
        voice_packet.read(data, 111)


@given(st.binary(max_size=80), st.integers(0, 127))
def test_any_bytes_are_read_or_refused(data: bytes, payload_type: int) -> None:
    """No bytes raise any other error, and no packet is longer than Opus allows."""
    try:
        packet = voice_packet.read(data, payload_type)
    except ProtocolError:
        return
    assert packet is None or 0 < packet.samples <= MAX_SAMPLES
