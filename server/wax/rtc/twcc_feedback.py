"""Transport-wide congestion control feedback: when each packet arrived at the browser. Pure.

draft-holmer-rmcat-transport-wide-cc-extensions-01, section 3.1: RTCP RTPFB (RFC 4585), format 15.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

from wax.errors import ProtocolError

if TYPE_CHECKING:
    from collections.abc import Sequence

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
_SYMBOLS: Final = 0x3FFF
_ONE_BIT_SHIFTS: Final = tuple(range(13, -1, -1))
_TWO_BIT_SHIFTS: Final = tuple(range(12, -1, -2))


class Feedback(NamedTuple):
    """Feedback on `packets` consecutive packets, the first of them `sequence_number` (16 bits).

    `arrivals` lists the packets that had arrived, in order: the offset from the first packet, and
    seconds on the browser's clock, which wraps after `PERIOD_S` and may be negative. Missing
    packets have no entry, because two bytes can announce thousands of them.
    """

    sequence_number: int
    packets: int
    arrivals: Sequence[tuple[int, float]]


def parse(packet: bytes) -> Feedback:
    """Parse one RTCP packet with its header; raises `ProtocolError` for anything but feedback.

    The work is proportional to the packet's length.
    """
    end = _checked_end(packet)
    count = packet[14] << 8 | packet[15]
    arrived, at = _arrived(packet, end, count)
    ticks = _REFERENCE_TICKS * int.from_bytes(packet[16:19], "big", signed=True)
    arrivals: list[tuple[int, float]] = []
    for place, size in arrived:
        if size == 1:
            ticks += packet[at]
        else:
            delta = packet[at] << 8 | packet[at + 1]
            ticks += delta - 0x10000 if delta & 0x8000 else delta
        at += size
        arrivals.append((place, ticks * TICK_S))
    return Feedback(packet[12] << 8 | packet[13], count, arrivals)


def _checked_end(packet: bytes) -> int:
    """Return where the chunks and receive deltas end, before any padding."""
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


def _arrived(packet: bytes, end: int, count: int) -> tuple[list[tuple[int, int]], int]:
    """Return the offset of each packet that arrived, and the bytes of its receive delta.

    Also return where the receive deltas start.
    """
    if count == 0:
        raise ProtocolError("transport feedback about no packet")
    arrived: list[tuple[int, int]] = []
    place, at, times = 0, _HEADER_BYTES, 0
    while place < count:
        if at + 2 > end:
            raise ProtocolError("transport feedback with fewer statuses than it announces")
        chunk = packet[at] << 8 | packet[at + 1]
        at += 2
        length, symbols = _statuses(chunk, min(count - place, end))
        for index, symbol in enumerate(symbols):
            if symbol == 3:
                raise ProtocolError("transport feedback with a status that does not exist")
            if symbol:
                arrived.append((place + index, symbol))
                times += symbol
        if at + times > end:
            raise ProtocolError("transport feedback with fewer arrivals than it announces")
        place += length
    return arrived, at


def _statuses(chunk: int, most: int) -> tuple[int, Sequence[int]]:
    """Return how many statuses a chunk has, and the first `most` of them; none if all are 0."""
    if not chunk & _VECTOR:
        length, symbol = chunk & _RUN, chunk >> 13
        return length, (symbol,) * min(length, most) if symbol else ()
    shifts, mask = (_TWO_BIT_SHIFTS, 3) if chunk & _TWO_BITS else (_ONE_BIT_SHIFTS, 1)
    if not chunk & _SYMBOLS:
        return len(shifts), ()
    return len(shifts), [chunk >> shift & mask for shift in shifts[:most]]
