"""Parses a browser's RTCP (RFC 3550, 6.4; RFC 4585; RFC 5104, 4.3.1). Pure.

Parsed by hand, because aiortc makes objects of everything, and a list of all that a NACK names: up
to 17 numbers for four bytes. Here no datagram costs more than a browser's, whatever is in it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from struct import Struct
from typing import Final, NamedTuple

MOST_PACKETS: Final = 32
"""Packets read per datagram. A browser sends a report, a name, and a few requests per stream."""
MOST_FEEDBACK: Final = 4
"""Feedback packets among these: libwebrtc sends one, or two if the times do not fit."""
MOST_NACKED: Final = 256
"""Sequence numbers requested by one datagram: more than two seconds of pictures."""

_SENDER_REPORT: Final = 200
_RECEIVER_REPORT: Final = 201
_RTPFB: Final = 205
_PSFB: Final = 206
_NACK: Final = 1
_TRANSPORT_FEEDBACK: Final = 15
_PLI: Final = 1
_FIR: Final = 4
_HEADER: Final = Struct("!BBH")
_REPORT: Final = Struct("!LBxxxLLLL")
_SSRC: Final = Struct("!L")
_ASKED: Final = Struct("!HH")
_REPORTER_BYTES: Final = {_SENDER_REPORT: 28, _RECEIVER_REPORT: 8}
"""The bytes before the report blocks."""


class ReportBlock(NamedTuple):
    """A report block: the share lost lately (1/256), and LSR and DLSR (1/65536 s)."""

    fraction_lost: int
    last_report: int
    delay: int


@dataclass(frozen=True, slots=True)
class HeardRtcp:
    """The contents of one datagram, by SSRC of ours, or a number that claims to be one."""

    feedback: list[bytes] = field(default_factory=list)
    """Packets of transport-wide feedback, to be parsed."""
    reports: dict[int, ReportBlock] = field(default_factory=dict)
    nacks: dict[int, list[int]] = field(default_factory=dict)
    """Sequence numbers to retransmit."""
    keyframes: set[int] = field(default_factory=set)


def read(compound: bytes) -> HeardRtcp:
    """Read one datagram; never raises. Everything after a wrong header or length is ignored."""
    heard = HeardRtcp()
    at = 0
    for _ in range(MOST_PACKETS):
        if at + 4 > len(compound):
            break
        first, kind, words = _HEADER.unpack_from(compound, at)
        until = at + 4 + 4 * words
        if first >> 6 != 2 or until > len(compound):
            break
        end = until - (compound[until - 1] if first & 0x20 else 0)
        if kind == _RTPFB and first & 0x1F == _TRANSPORT_FEEDBACK:
            if len(heard.feedback) < MOST_FEEDBACK:
                heard.feedback.append(compound[at:until])
        elif kind in _REPORTER_BYTES:
            _read_reports(heard, compound, at + _REPORTER_BYTES[kind], end, first & 0x1F)
        elif kind in (_RTPFB, _PSFB) and end - at >= 12:
            _read_request(heard, compound, at, end, (kind, first & 0x1F))
        at = until
    return heard


def _read_reports(heard: HeardRtcp, compound: bytes, at: int, end: int, count: int) -> None:
    for begin in range(at, min(at + _REPORT.size * count, end - _REPORT.size + 1), _REPORT.size):
        ssrc, fraction, _highest, _jitter, last, delay = _REPORT.unpack_from(compound, begin)
        heard.reports[ssrc] = ReportBlock(fraction, last, delay)


def _read_request(
    heard: HeardRtcp, compound: bytes, at: int, end: int, what: tuple[int, int]
) -> None:
    (ssrc,) = _SSRC.unpack_from(compound, at + 8)
    if what == (_RTPFB, _NACK):
        asked = heard.nacks.setdefault(ssrc, [])
        left = MOST_NACKED - sum(map(len, heard.nacks.values()))
        asked += _numbers(compound, at + 12, end, left)
    elif what == (_PSFB, _PLI):
        heard.keyframes.add(ssrc)
    elif what == (_PSFB, _FIR):
        for begin in range(at + 12, end - 7, 8):
            heard.keyframes.add(*_SSRC.unpack_from(compound, begin))


def _numbers(compound: bytes, at: int, end: int, most: int) -> list[int]:
    """Return the numbers of a generic NACK (RFC 4585, 6.2.1), the first `most` of them."""
    numbers: list[int] = []
    for begin in range(at, end - 3, 4):
        number, following = _ASKED.unpack_from(compound, begin)
        numbers.append(number)
        while following:
            lowest = following & -following
            numbers.append((number + lowest.bit_length()) & 0xFFFF)
            following ^= lowest
        if len(numbers) >= most:
            break
    return numbers[:most]
