"""A browser's RTCP is parsed, and no datagram yields more than a browser's would."""

from __future__ import annotations

from random import Random
from struct import pack

import pytest
from aiortc.rtp import (
    RtcpByePacket,
    RtcpPacket,
    RtcpPsfbPacket,
    RtcpReceiverInfo,
    RtcpRrPacket,
    RtcpRtpfbPacket,
    RtcpSdesPacket,
    RtcpSenderInfo,
    RtcpSourceInfo,
    RtcpSrPacket,
    pack_remb_fci,
)
from hypothesis import given
from hypothesis import strategies as st
from tests.rtc.browser_feedback import feedback_packet

from wax.rtc.rtcp import MOST_FEEDBACK, MOST_NACKED, ReportBlock, read

NAME = bytes(RtcpSdesPacket(chunks=[RtcpSourceInfo(ssrc=1, items=[(1, b"name")])]))
EMPTY = bytes(RtcpRrPacket(ssrc=1))
FEEDBACK = feedback_packet(7, [1, None, 3], Random(1))
PLI = bytes(RtcpPsfbPacket(fmt=1, ssrc=1, media_ssrc=5))


def _block(ssrc: int) -> RtcpReceiverInfo:
    return RtcpReceiverInfo(
        ssrc=ssrc, fraction_lost=9, packets_lost=1, highest_sequence=2, jitter=3, lsr=4, dlsr=5
    )


def _nack(ssrc: int, *lost: int) -> bytes:
    return bytes(RtcpRtpfbPacket(fmt=1, ssrc=1, media_ssrc=ssrc, lost=list(lost)))


def test_a_browsers_rtcp_is_read() -> None:
    """A compound's reports, requests and feedback are read, whatever packets are between them."""
    sender_info = RtcpSenderInfo(ntp_timestamp=1, rtp_timestamp=2, packet_count=3, octet_count=4)
    remb = RtcpPsfbPacket(fmt=15, ssrc=1, media_ssrc=0, fci=pack_remb_fci(10**6, [5, 6]))
    fir = RtcpPsfbPacket(fmt=4, ssrc=1, media_ssrc=0, fci=pack("!LBxxxLBxxx", 7, 1, 8, 1))
    heard = read(
        bytes(RtcpRrPacket(ssrc=1, reports=[_block(5), _block(6)]))
        + NAME
        + bytes(RtcpSrPacket(ssrc=2, sender_info=sender_info, reports=[_block(9)]))
        + FEEDBACK
        + bytes(remb)
        + _nack(5, 1, 2, 40)
        + _nack(6, 65_535)
        + PLI
        + bytes(fir)
        + bytes(RtcpByePacket(sources=[5]))
        + FEEDBACK
    )
    assert heard.reports == dict.fromkeys((5, 6, 9), ReportBlock(9, 4, 5))
    assert heard.nacks == {5: [1, 2, 40], 6: [65_535]}
    assert heard.keyframes == {5, 7, 8}
    assert heard.feedback == [FEEDBACK, FEEDBACK]


@given(st.lists(st.integers(0, 0xFFFF), min_size=1, max_size=40), st.integers(0, 0xFFFF))
def test_a_nack_means_what_aiortc_means_by_it(numbers: list[int], following: int) -> None:
    """NACK numbers and masks are read by RFC 4585, also across the wrap."""
    body = pack("!LL", 1, 5) + b"".join(pack("!HH", number, following) for number in numbers)
    packet = pack("!BBH", 0x81, 205, len(body) // 4) + body
    (known,) = RtcpPacket.parse(packet)
    assert isinstance(known, RtcpRtpfbPacket)
    wanted = [number % 2**16 for number in known.lost]
    assert read(packet).nacks == {5: wanted[:MOST_NACKED]}


@given(st.binary(max_size=300))
def test_nothing_is_raised(data: bytes) -> None:
    """Any bytes are read without an error."""
    read(data)
    for start in (b"\x81\xc9", b"\x9f\xc8", b"\x81\xcd", b"\x8f\xcd", b"\xa4\xce"):
        packet = start + (len(data) // 4).to_bytes(2) + data
        heard = read(packet)
        assert sum(map(len, heard.feedback)) <= len(packet)


@given(st.binary(max_size=30), st.binary(max_size=30))
def test_a_wrong_length_ends_parsing(before: bytes, after: bytes) -> None:
    """Packets before a wrong length are read, those after it are not."""
    broken = bytes((0x80, 201, 0xFF, 0xFF))
    assert read(FEEDBACK + broken + after).feedback == [FEEDBACK]
    assert read(b"\x00" + before + FEEDBACK).feedback == []
    assert read(EMPTY + FEEDBACK[:-4]).feedback == []


@pytest.mark.parametrize(
    ("datagram", "packets", "asked"),
    [
        (FEEDBACK * 40, MOST_FEEDBACK, 0),
        (EMPTY * 31 + PLI, 0, 0),
        (EMPTY * 32 + PLI, 0, 0),
        (_nack(5, *range(0, 4000, 17)), 0, 4000 // 17 + 1),
        (_nack(5, *range(2000)), 0, MOST_NACKED),
        (_nack(5, *range(200)) + _nack(6, *range(200)), 0, MOST_NACKED),
    ],
)
def test_what_a_datagram_yields_is_bounded(datagram: bytes, packets: int, asked: int) -> None:
    """Contents beyond the limits are ignored, and do not affect those before."""
    heard = read(datagram)
    assert len(heard.feedback) == packets
    assert sum(map(len, heard.nacks.values())) == asked
    assert heard.keyframes == ({5} if datagram == EMPTY * 31 + PLI else set())
