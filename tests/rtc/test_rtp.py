"""Packets and reports on the wire, read by a parser that is not ours."""

from __future__ import annotations

from aiortc.rtcrtpparameters import RTCRtpHeaderExtensionParameters, RTCRtpParameters
from aiortc.rtp import (
    HeaderExtensionsMap,
    RtcpPacket,
    RtcpSdesPacket,
    RtcpSrPacket,
    RtpPacket,
    unpack_header_extensions,
)
from hypothesis import given
from hypothesis import strategies as st

from wax.rtc import rtp
from wax.rtc.receiver_reports import SenderReportTimes
from wax.rtc.retransmission_buffer import RetransmissionBuffer

UINT16 = st.integers(0, 2**16 - 1)
UINT32 = st.integers(0, 2**32 - 1)


@given(
    payload_type=st.integers(96, 127),
    marker=st.booleans(),
    sequence_number=UINT16,
    timestamp=UINT32,
    ssrc=UINT32,
    payload=st.binary(min_size=1, max_size=1200),
    transport_sequence=st.none() | UINT16,
)
def test_a_packet_is_read_as_it_was_meant(
    *,
    payload_type: int,
    marker: bool,
    sequence_number: int,
    timestamp: int,
    ssrc: int,
    payload: bytes,
    transport_sequence: int | None,
) -> None:
    """Header, transport-wide number and payload are read back unchanged."""
    ids = rtp.ExtensionIds(transport_sequence=3, playout_delay=5)
    packet = rtp.Packet(payload_type, sequence_number, ssrc, timestamp, marker, payload)
    data = packet.to_bytes(
        rtp.extension_block(ids, transport_sequence=transport_sequence, playout_delay=None)
    )
    known = HeaderExtensionsMap()
    known.configure(
        RTCRtpParameters(
            headerExtensions=[RTCRtpHeaderExtensionParameters(id=3, uri=rtp.TRANSPORT_SEQUENCE)]
        )
    )
    read = RtpPacket.parse(data, known)
    assert read.payload_type == payload_type
    assert bool(read.marker) == marker
    assert read.sequence_number == sequence_number
    assert read.timestamp == timestamp
    assert read.ssrc == ssrc
    assert read.payload == payload
    assert read.extensions.transport_sequence_number == transport_sequence


@given(st.integers(0, 4095), st.integers(0, 4095))
def test_a_playout_delay_is_two_times_twelve_bits(least: int, most: int) -> None:
    """The playout delay is encoded as minimum and maximum in steps of 10 ms, after the number."""
    ids = rtp.ExtensionIds(transport_sequence=3, playout_delay=5)
    block = rtp.extension_block(
        ids, transport_sequence=7, playout_delay=rtp.PlayoutDelay(least, most)
    )
    read = dict(unpack_header_extensions(int.from_bytes(block[:2], "big"), block[4:]))
    assert read[3] == b"\x00\x07"
    assert int.from_bytes(read[5], "big") == least << 12 | most
    assert len(block) % 4 == 0


def test_extensions_that_were_not_negotiated_are_left_out() -> None:
    """Without agreed extensions a packet has none, not even an empty block."""
    delay = rtp.PlayoutDelay(0, 0)
    assert rtp.extension_block(rtp.ExtensionIds(), transport_sequence=7, playout_delay=delay) == b""


@given(ntp=st.integers(0, 2**64 - 1), timestamp=UINT32, cname=st.text("abc-", max_size=40))
def test_a_sender_report_is_read_as_it_was_meant(ntp: int, timestamp: int, cname: str) -> None:
    """The two times, the counts and the name are read back unchanged."""
    data = rtp.sender_report(
        ssrc=9, ntp=ntp, timestamp=timestamp, packets=2**32 + 5, octets=77, cname=cname
    )
    report, description = RtcpPacket.parse(data)
    assert isinstance(report, RtcpSrPacket)
    assert report.ssrc == 9
    assert report.sender_info.ntp_timestamp == ntp
    assert report.sender_info.rtp_timestamp == timestamp
    assert (report.sender_info.packet_count, report.sender_info.octet_count) == (5, 77)
    assert isinstance(description, RtcpSdesPacket)
    assert description.chunks[0].items == [(1, cname.encode())]


def test_ntp_begins_in_1900() -> None:
    """1970 is 2 208 988 800 s of NTP, and half a second is half of the lower 32 bits."""
    assert rtp.ntp_time(0.5) == 2_208_988_800 << 32 | 1 << 31


def test_a_round_trip_longer_than_the_interval_of_reports_is_found() -> None:
    """Reports on any of the last sixteen sender reports give a round trip, others give none."""
    times = SenderReportTimes()
    for second in range(20):
        times.sent((1000 + second) << 32, float(second))
    assert times.round_trip_s((1017 << 16) & 0xFFFFFFFF, 32768, 19.75) == 2.25
    assert times.round_trip_s((1002 << 16) & 0xFFFFFFFF, 0, 19.75) is None
    assert times.round_trip_s(0, 0, 19.75) is None
    assert times.round_trip_s((1019 << 16) & 0xFFFFFFFF, 65536 * 9, 19.75) is None


def test_old_packets_are_forgotten() -> None:
    """As many packets are kept as a browser may request, of the last two seconds, and no more."""
    history = RetransmissionBuffer()

    def kept(number: int) -> float | None:
        found = history.get(number % 2**16)
        assert found is None or found[0].sequence_number == number % 2**16
        return None if found is None else found[1]

    first = 2**16 - 750  # the numbers wrap on the way
    for number in range(first, first + 1500, 4):
        history.add([_numbered(number + n) for n in range(4)], 0.0)
    assert kept(first + 475) is None
    assert kept(first + 476) == kept(first + 1499) == 0.0
    assert kept(first + 1500) is None
    history.add([_numbered(first + 1500)], 2.0)
    assert kept(first + 1499) == 0.0
    history.add([], 2.0)
    history.add([_numbered(first + 1501)], 2.001)
    assert kept(first + 1499) is None
    assert kept(first + 1500) == 2.0


def _numbered(number: int) -> rtp.Packet:
    return rtp.Packet(96, number % 2**16, 1, 2, False, b"")
