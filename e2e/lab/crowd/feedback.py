"""Transport-wide feedback as Chromium sends it: when each packet came, a few times a second.

draft-holmer-rmcat-transport-wide-cc-extensions-01, 3.1. Chromium spends a twentieth of what it
receives on it, but sends at least every 250 ms and at most every 50 ms.
"""

from __future__ import annotations

from struct import pack
from typing import Final

URI: Final = "http://www.ietf.org/id/draft-holmer-rmcat-transport-wide-cc-extensions-01"
LEAST_EVERY_S: Final = 0.05
MOST_EVERY_S: Final = 0.25
_SHARE: Final = 0.05
_TYPICAL_BITS: Final = 8 * 68
"""Of a feedback packet with everything around it, as Chromium reckons."""

_TICK_S: Final = 0.000_25
_TICKS_IN_REFERENCE: Final = 256
_REFERENCE_S: Final = _TICK_S * _TICKS_IN_REFERENCE
_MOST_SPAN: Final = 0x1FFF
"""Packets in one run; more than that have not been waited for in any sensible stream."""
_NOT, _SMALL, _LARGE = 0, 1, 2
_LEAST_RUN: Final = 7


class Feedback:
    """Collects arrivals of one transport. Times are monotonic seconds; pure."""

    def __init__(self) -> None:
        self._came: dict[int, float] = {}
        self._next: int | None = None
        self._newest = 0
        self._count = 0

    def came(self, sequence: int, at_s: float) -> None:
        """Take a packet's 16 bits; what comes after its successors were told is told late."""
        if self._next is None:
            self._newest = sequence
            self._next = sequence
        else:
            ahead = (sequence - self._newest + 0x8000) % 0x10000 - 0x8000
            sequence = self._newest + ahead
            self._newest = max(self._newest, sequence)
        self._came.setdefault(sequence, at_s)

    def take(self, sender_ssrc: int, media_ssrc: int) -> bytes | None:
        """Return the RTCP packet about all since the last; None where nothing came."""
        if not self._came or self._next is None:
            return None
        last = max(self._came)
        first = max(min(self._next, *self._came), last - _MOST_SPAN + 1)
        reference = int(self._came[min(self._came)] / _REFERENCE_S)
        before_ticks = reference * _TICKS_IN_REFERENCE
        symbols: list[int] = []
        deltas = b""
        for sequence in range(first, last + 1):
            at_s = self._came.get(sequence)
            if at_s is None:
                symbols.append(_NOT)
                continue
            ticks = round(at_s / _TICK_S)
            delta = max(-0x8000, min(0x7FFF, ticks - before_ticks))
            before_ticks += delta
            small = 0 <= delta <= 0xFF
            symbols.append(_SMALL if small else _LARGE)
            deltas += pack("!B", delta) if small else pack("!h", delta)
        body = pack("!LLHH", sender_ssrc, media_ssrc, first & 0xFFFF, len(symbols))
        body += pack("!L", (reference & 0xFFFFFF) << 8 | self._count & 0xFF)
        body += _chunks(symbols) + deltas
        self._count += 1
        self._came.clear()
        self._next = last + 1
        return _rtcp(body)


def every_s(rate_bps: float) -> float:
    """How long Chromium waits between two at this rate of reception."""
    share_bps = max(1.0, _SHARE * rate_bps)
    return min(MOST_EVERY_S, max(LEAST_EVERY_S, _TYPICAL_BITS / share_bps))


def _chunks(symbols: list[int]) -> bytes:
    """Write runs of one symbol, else seven symbols of two bits."""
    chunks = b""
    at = 0
    while at < len(symbols):
        run = 1
        while at + run < len(symbols) and symbols[at + run] == symbols[at] and run < _MOST_SPAN:
            run += 1
        if run >= _LEAST_RUN or at + run == len(symbols):
            chunks += pack("!H", symbols[at] << 13 | run)
            at += run
            continue
        some = symbols[at : at + 7]
        bits = 0
        for symbol in some + [_NOT] * (7 - len(some)):
            bits = bits << 2 | symbol
        chunks += pack("!H", 0xC000 | bits)
        at += 7
    return chunks


def _rtcp(body: bytes) -> bytes:
    """Write the header (RFC 4585, 6.1: RTPFB is 205) and pad to 32 bits (RFC 3550, 6.4.1)."""
    padding = -len(body) % 4
    if padding:
        body += bytes(padding - 1) + bytes([padding])
    first = 0x80 | (0x20 if padding else 0) | 15
    return pack("!BBH", first, 205, len(body) // 4) + body
