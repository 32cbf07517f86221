"""Receiving without decoding: headers are read as aiortc writes them, and answered."""

from __future__ import annotations

from struct import unpack_from

import pytest
from aiortc.rtcrtpparameters import RTCRtpHeaderExtensionParameters, RTCRtpParameters
from aiortc.rtp import HeaderExtensions, HeaderExtensionsMap, RtpPacket
from hypothesis import given
from hypothesis import strategies as st

from wax.client import rtp_header as header
from wax.client.retransmission import MAX_RETRIES, RETRY_S, RetransmissionRequests
from wax.client.sdp import agreed
from wax.client.transport_feedback import (
    MAX_INTERVAL_S,
    MIN_INTERVAL_S,
    URI,
    TransportFeedback,
    interval_s,
)
from wax.rtc.rtcp import read
from wax.rtc.twcc_feedback import parse

ANSWER = f"""v=0
m=audio 9 UDP/TLS/RTP/SAVPF 96
a=rtpmap:96 opus/48000/2
a=extmap:5 {URI}
m=video 9 UDP/TLS/RTP/SAVPF 97 98
a=rtpmap:97 VP8/90000
a=rtpmap:98 rtx/90000
m=application 9 UDP/DTLS/SCTP webrtc-datachannel
"""


def wire(sequence: int | None, payload: bytes = b"12345678") -> bytes:
    parameters = RTCRtpParameters(
        headerExtensions=[
            RTCRtpHeaderExtensionParameters(id=1, uri="urn:ietf:params:rtp-hdrext:sdes:mid"),
            RTCRtpHeaderExtensionParameters(id=5, uri=URI),
        ]
    )
    extensions = HeaderExtensionsMap()
    extensions.configure(parameters)
    packet = RtpPacket(
        payload_type=97, marker=1, sequence_number=65535, timestamp=12, ssrc=34, payload=payload
    )
    packet.csrc = [7, 8]
    packet.extensions = HeaderExtensions(mid="0", transport_sequence_number=sequence)
    return packet.serialize(extensions)


@pytest.mark.parametrize("sequence", [None, 0, 0xBEDE])
def test_a_header_is_read_as_it_was_written(sequence: int | None) -> None:
    """What aiortc writes is read without its key: fields, extension and where the payload is."""
    data = wire(sequence)
    assert header.is_rtp(data)
    read = header.read(data, 5)
    assert read == (97, True, 65535, 12, 34, b"12345678", sequence)


@given(data=st.binary(max_size=60), extension_id=st.none() | st.integers(1, 14))
def test_no_bytes_are_too_strange(data: bytes, extension_id: int | None) -> None:
    """Any bytes are parsed, refused, or recognised as not RTP; nothing is raised."""
    if header.is_rtp(data):
        header.read(data, extension_id)


def test_what_is_not_media_goes_its_way() -> None:
    """RTCP, DTLS and STUN are not taken for RTP."""
    for first, second in ((0x80, 200), (0x8F, 205), (22, 254), (0, 1)):
        assert not header.is_rtp(bytes([first, second, *range(20)]))


def read_feedback(data: bytes) -> tuple[int, dict[int, float]]:
    """Read a feedback packet by the draft's 3.1: its count, and when each packet came, s."""
    first, kind, words = unpack_from("!BBH", data)
    assert (first & 0x1F, kind, 4 * words + 4) == (15, 205, len(data))
    base, count, reference = unpack_from("!HHL", data, 12)
    at = 20
    symbols: list[int] = []
    while len(symbols) < count:
        (chunk,) = unpack_from("!H", data, at)
        at += 2
        if chunk >> 15 == 0:
            symbols += [chunk >> 13] * (chunk & 0x1FFF)
        else:
            assert chunk >> 14 == 3
            symbols += [chunk >> shift & 3 for shift in range(12, -2, -2)]
    ticks = (reference >> 8) * 256
    came = {}
    for place, symbol in enumerate(symbols[:count]):
        if symbol == 0:
            continue
        size = 1 if symbol == 1 else 2
        (delta,) = unpack_from("!B" if size == 1 else "!h", data, at)
        at += size
        ticks += delta
        came[(base + place) & 0xFFFF] = ticks * 0.00025
    assert len(data) - at == (data[-1] if first & 0x20 else 0)
    return reference & 0xFF, came


@given(
    first=st.integers(0, 0xFFFF),
    arrivals=st.lists(
        st.tuples(st.integers(1, 30), st.integers(-40, 3000)), min_size=1, max_size=60
    ),
)
def test_feedback_says_when_each_packet_came(first: int, arrivals: list[tuple[int, int]]) -> None:
    """Feedback has each arrival exact to the tick, for lost, late and reordered packets.

    The server's own parser finds the same number.
    """
    feedback = TransportFeedback()
    at_s, sequence, expected = 1000.0, first, {}
    for ahead, ticks in arrivals:
        sequence, at_s = sequence + ahead, at_s + 0.00025 * ticks
        feedback.arrived(sequence & 0xFFFF, at_s)
        expected[sequence & 0xFFFF] = at_s
    packet = feedback.take(1, 2)
    assert packet is not None
    count, came = read_feedback(packet)
    assert count == 0
    assert came == pytest.approx(expected, abs=0.00026)
    (found,) = read(packet).feedback
    assert len(parse(found).arrivals) == len(came)
    assert feedback.take(1, 2) is None


def test_what_was_lost_between_two_is_told() -> None:
    """The next feedback begins where the last ended, so that no loss falls between them."""
    feedback = TransportFeedback()
    feedback.arrived(10, 1.0)
    feedback.take(1, 2)
    feedback.arrived(13, 1.1)
    packet = feedback.take(1, 2)
    assert packet is not None
    assert unpack_from("!HH", packet, 12) == (11, 3)
    assert read_feedback(packet)[0] == 1


def test_feedback_takes_a_twentieth() -> None:
    """The interval is Chromium's: shorter at a higher rate, and bounded both ways."""
    assert interval_s(10e6) == MIN_INTERVAL_S
    assert interval_s(0) == MAX_INTERVAL_S
    assert 8 * 68 / interval_s(100_000) == pytest.approx(0.05 * 100_000)


def test_what_is_missing_is_asked_for_until_it_comes() -> None:
    """A gap is requested at once and again until it arrives or a keyframe is requested."""
    missing = RetransmissionRequests()
    for sequence in (65534, 2):
        missing.arrived(sequence)
    assert missing.due(1.0) == ([65535, 0, 1], False)
    missing.arrived(0)
    assert missing.due(1.0 + RETRY_S / 2) == ([], False)
    asked = [missing.due(1.0 + 1.01 * RETRY_S * turn) for turn in range(1, MAX_RETRIES + 1)]
    assert asked[:-1] == [([65535, 1], False)] * (MAX_RETRIES - 1)
    assert asked[-1] == ([], True)


def test_an_answer_is_understood() -> None:
    """Payload types by kind, repeats apart, and the extension's number; without it, none."""
    found = agreed(ANSWER)
    assert found.kinds == {96: "audio", 97: "video"}
    assert found.retransmissions == {98}
    assert found.extension_id == 5
    assert agreed(ANSWER.replace(URI, "urn:another")).extension_id is None
