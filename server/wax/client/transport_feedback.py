"""Writes transport-wide feedback as Chromium does: the arrival of each packet (pure).

draft-holmer-rmcat-transport-wide-cc-extensions-01, 3.1. `wax.rtc.twcc_feedback` parses it.
"""

from __future__ import annotations

from struct import pack
from typing import Final

URI: Final = "http://www.ietf.org/id/draft-holmer-rmcat-transport-wide-cc-extensions-01"

MIN_INTERVAL_S: Final = 0.05
MAX_INTERVAL_S: Final = 0.25
_SHARE: Final = 0.05
"""Chromium spends this share of the received rate on feedback, between the two intervals."""
_PACKET_BITS: Final = 8 * 68
"""Chromium's estimate of one feedback packet with all its headers."""

_TICK_S: Final = 0.000_25
_TICKS_IN_REFERENCE: Final = 256
_REFERENCE_S: Final = _TICK_S * _TICKS_IN_REFERENCE
_MAX_RUN: Final = 0x1FFF
_MIN_RUN: Final = 7
_MISSING, _SMALL_DELTA, _LARGE_DELTA = 0, 1, 2


class TransportFeedback:
    """Collects the arrivals of one transport; times in seconds of a monotonic clock."""

    def __init__(self) -> None:
        self._arrived: dict[int, float] = {}
        self._next: int | None = None
        self._newest = 0
        self._count = 0

    def arrived(self, sequence: int, at_s: float) -> None:
        """Count a packet's 16-bit number; one older than those reported is reported late."""
        if self._next is None:
            self._newest = sequence
            self._next = sequence
        else:
            ahead = (sequence - self._newest + 0x8000) % 0x10000 - 0x8000
            sequence = self._newest + ahead
            self._newest = max(self._newest, sequence)
        self._arrived.setdefault(sequence, at_s)

    def take(self, sender_ssrc: int, media_ssrc: int) -> bytes | None:
        """Return the RTCP packet for all arrivals since the last one, None without any."""
        if not self._arrived or self._next is None:
            return None
        last = max(self._arrived)
        first = max(min(self._next, *self._arrived), last - _MAX_RUN + 1)
        reference = int(self._arrived[min(self._arrived)] / _REFERENCE_S)
        before_ticks = reference * _TICKS_IN_REFERENCE
        symbols: list[int] = []
        deltas = b""
        for sequence in range(first, last + 1):
            at_s = self._arrived.get(sequence)
            if at_s is None:
                symbols.append(_MISSING)
                continue
            ticks = round(at_s / _TICK_S)
            delta = max(-0x8000, min(0x7FFF, ticks - before_ticks))
            before_ticks += delta
            small = 0 <= delta <= 0xFF
            symbols.append(_SMALL_DELTA if small else _LARGE_DELTA)
            deltas += pack("!B", delta) if small else pack("!h", delta)
        body = pack("!LLHH", sender_ssrc, media_ssrc, first & 0xFFFF, len(symbols))
        body += pack("!L", (reference & 0xFFFFFF) << 8 | self._count & 0xFF)
        body += _chunks(symbols) + deltas
        self._count += 1
        self._arrived.clear()
        self._next = last + 1
        return _rtcp(body)


def interval_s(rate_bps: float) -> float:
    """Return Chromium's interval between two feedback packets at this received rate."""
    share_bps = max(1.0, _SHARE * rate_bps)
    return min(MAX_INTERVAL_S, max(MIN_INTERVAL_S, _PACKET_BITS / share_bps))


def _chunks(symbols: list[int]) -> bytes:
    """Write runs of one symbol, else vectors of seven two-bit symbols."""
    chunks = b""
    at = 0
    while at < len(symbols):
        run = 1
        while at + run < len(symbols) and symbols[at + run] == symbols[at] and run < _MAX_RUN:
            run += 1
        if run >= _MIN_RUN or at + run == len(symbols):
            chunks += pack("!H", symbols[at] << 13 | run)
            at += run
            continue
        some = symbols[at : at + 7]
        bits = 0
        for symbol in some + [_MISSING] * (7 - len(some)):
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
