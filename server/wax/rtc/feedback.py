"""Transport-wide congestion control feedback: when each packet arrived at the browser. Pure.

draft-holmer-rmcat-transport-wide-cc-extensions-01, section 3.1: RTCP RTPFB (RFC 4585), format 15.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from wax.errors import ProtocolError

TICK_S: Final = 250e-6
"""The resolution of arrival times."""

PERIOD_S: Final = 2**24 * 0.064
"""The browser's clock wraps after this, 12 days and 10 hours."""

_RTPFB: Final = 205
_FORMAT: Final = 15
_HEADER_BYTES: Final = 20
_REFERENCE_TICKS: Final = 256
_VECTOR: Final = 0x8000
_TWO_BITS: Final = 0x4000
_RUN: Final = 0x1FFF
_ONE_BIT_SHIFTS: Final = tuple(range(13, -1, -1))
_TWO_BIT_SHIFTS: Final = tuple(range(12, -1, -2))


@dataclass(frozen=True, slots=True)
class Feedback:
    """Feedback on consecutive packets from `sequence_number` (16 bits) on.

    `arrivals` has one entry per packet: seconds on the browser's clock, which wraps after
    `PERIOD_S` and may be negative; None if the packet had not arrived.
    """

    sequence_number: int
    arrivals: tuple[float | None, ...]


def find(compound: bytes) -> list[bytes]:
    """Return the feedback in one datagram of RTCP (RFC 3550, 6.1); never raises.

    Everything after a wrong header or length is ignored.
    """
    found: list[bytes] = []
    at, end = 0, len(compound)
    while at + 4 <= end and compound[at] >> 6 == 2:
        until = at + 4 * (1 + (compound[at + 2] << 8 | compound[at + 3]))
        if until > end:
            break
        if compound[at + 1] == _RTPFB and compound[at] & 0x1F == _FORMAT:
            found.append(compound[at:until])
        at = until
    return found


def parse(packet: bytes) -> Feedback:
    """Parse one RTCP packet with its header; raises `ProtocolError` for anything but feedback."""
    end = _checked_end(packet)
    count = packet[14] << 8 | packet[15]
    symbols, at = _symbols(packet, end, count)
    if 3 in symbols:
        raise ProtocolError("transport feedback with a status that does not exist")
    if symbols.count(1) + 2 * symbols.count(2) > end - at:
        raise ProtocolError("transport feedback with fewer arrivals than it announces")
    ticks = _REFERENCE_TICKS * int.from_bytes(packet[16:19], "big", signed=True)
    arrivals: list[float | None] = []
    for symbol in symbols:
        if symbol == 0:
            arrivals.append(None)
            continue
        if symbol == 1:
            ticks += packet[at]
            at += 1
        else:
            delta = packet[at] << 8 | packet[at + 1]
            ticks += delta - 0x10000 if delta & 0x8000 else delta
            at += 2
        arrivals.append(ticks * TICK_S)
    return Feedback(packet[12] << 8 | packet[13], tuple(arrivals))


def _checked_end(packet: bytes) -> int:
    """Return where chunks and arrivals end, before any padding."""
    if len(packet) < _HEADER_BYTES:
        raise ProtocolError("transport feedback that is too short")
    if packet[0] & ~0x20 != 0x80 | _FORMAT or packet[1] != _RTPFB:
        raise ProtocolError("not transport feedback")
    if len(packet) != 4 * (1 + (packet[2] << 8 | packet[3])):
        raise ProtocolError("transport feedback with a wrong length")
    padding = packet[-1] if packet[0] & 0x20 else 0
    if packet[0] & 0x20 and not 0 < padding <= len(packet) - _HEADER_BYTES:
        raise ProtocolError("transport feedback with a wrong padding")
    return len(packet) - padding


def _symbols(packet: bytes, end: int, count: int) -> tuple[list[int], int]:
    """Read one status for each packet; also return where the arrivals start."""
    if count == 0:
        raise ProtocolError("transport feedback about no packet")
    symbols: list[int] = []
    at = _HEADER_BYTES
    while len(symbols) < count:
        if at + 2 > end:
            raise ProtocolError("transport feedback with fewer statuses than it announces")
        chunk = packet[at] << 8 | packet[at + 1]
        at += 2
        if not chunk & _VECTOR:
            symbols += [chunk >> 13] * min(chunk & _RUN, count - len(symbols))
        elif chunk & _TWO_BITS:
            symbols += [chunk >> shift & 3 for shift in _TWO_BIT_SHIFTS]
        else:
            symbols += [chunk >> shift & 1 for shift in _ONE_BIT_SHIFTS]
    del symbols[count:]
    return symbols, at
