"""Puts one speaker's packets in order and decides when each is due (pure).

A browser's jitter buffer also stretches sound; this one changes its delay in the pauses between
words, where nobody hears it.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Final

from wax.voice.packet import RATE_HZ, VoicePacket

_WINDOW_S: Final = 4.0
"""The delays of the packets in this window decide the playout delay."""
_LEAST_S: Final = 0.015
"""The least delay: the polling thread itself may be this late."""
_MOST_S: Final = 0.2
"""The greatest delay: a later voice is of no use to people beside the robot."""
_PAUSE_S: Final = 0.3
"""After a pause this long a browser may resume its timestamps where they stopped, so that earlier
delays no longer count."""
_MAX_PACKETS: Final = 64
_MAX_AHEAD: Final = RATE_HZ // 2
"""A larger jump of the timestamps restarts the stream."""
_MAX_CONCEALED: Final = RATE_HZ * 60 // 1000
"""A longer gap is a pause, or sounds like one."""
_STEP: Final = RATE_HZ // 100
_TOO_LATE_S: Final = 0.02
"""A packet is dropped if, even without it, the rest is this much later than necessary."""
_SKIP_EVERY_S: Final = 0.5
_UINT32: Final = 2**32


@dataclass(frozen=True, slots=True)
class Missing:
    """A number of lost samples at 48 kHz, to be concealed."""

    samples: int


class JitterBuffer:
    """Holds packets for as long as the delays of the last seconds require, to play them in order.

    Times are monotonic seconds. Packets are played in order and never twice. The buffer holds at
    most 64 packets, whatever arrives.
    """

    def __init__(self) -> None:
        self._source: int | None = None
        self._packets: dict[int, VoicePacket] = {}
        self._newest = 0
        self._transits: deque[tuple[float, float]] = deque()
        self._came_s = float("-inf")
        self._jitter_s = _LEAST_S
        self._next: int | None = None
        self._played_to = 0
        self._offset_s = 0.0
        self._concealed = 0
        self._skipped_s = float("-inf")

    @property
    def is_idle(self) -> bool:
        """Whether there is nothing to play until the next packet arrives."""
        return self._next is None and not self._packets

    def clear(self) -> None:
        """Drop all waiting packets, but keep the measured delays."""
        self._packets.clear()
        self._next = None
        self._source = None

    def push(self, packet: VoicePacket, now_s: float) -> None:
        """Add a packet that arrives now."""
        at = self._unwrapped(packet, now_s)
        self._came_s = now_s
        transit_s = now_s - at / RATE_HZ
        self._transits.append((now_s, transit_s))
        while len(self._transits) > 1 and (
            self._transits[0][0] < now_s - _WINDOW_S or len(self._transits) > 8 * _MAX_PACKETS
        ):
            self._transits.popleft()
        self._jitter_s = self._measured_s()
        if at < self._played_to:
            return
        if self._next is not None and at < self._next:
            if self._packets:
                # It was concealed already, and later packets are here. Raise the delay, so that
                # the next packet that is as late is waited for.
                self._offset_s = max(self._offset_s, self._base_s + self._jitter_s)
                return
            self._next = None  # all packets are late now: resume here with a longer delay
        self._packets.setdefault(at, packet)
        while len(self._packets) > _MAX_PACKETS:
            del self._packets[min(self._packets)]

    def pop_due(self, now_s: float) -> VoicePacket | Missing | None:
        """Remove and return the next item that is due, or None; call it until it returns None."""
        while self._packets:
            head = min(self._packets)
            at = self._due(head, now_s)
            if at is None:
                return None
            if 0 < head - at <= _MAX_CONCEALED:
                return self._conceal(at, min(head - at, _STEP))
            if head > at:
                self._next = None  # a pause, after which the delay may change
            elif (packet := self._played(head, at, now_s)) is not None:
                return packet
        return self._concealed_at_end(now_s)

    def _due(self, head: int, now_s: float) -> int | None:
        """Return the timestamp to play from; None while it is not due."""
        if self._next is None:
            # No earlier than now, or the late packet would count as missing at once.
            self._offset_s = max(self._base_s + self._jitter_s, now_s - head / RATE_HZ)
            at = head
        else:
            at = self._next
        if now_s < self._offset_s + at / RATE_HZ:
            return None
        if self._next is None:
            self._next, self._concealed = at, 0
        return at

    def _played(self, head: int, at: int, now_s: float) -> VoicePacket | None:
        """Remove the first packet and return it; None if it is skipped."""
        packet = self._packets.pop(head)
        if head < at:
            return None  # it overlaps the last packet, which no browser causes
        self._next = self._played_to = head + packet.samples
        self._concealed = 0
        return None if self._is_skipped(packet, now_s) else packet

    def _concealed_at_end(self, now_s: float) -> Missing | None:
        """Conceal for a while when packets run out, in case they are only late."""
        if self._next is None or now_s < self._offset_s + self._next / RATE_HZ:
            return None
        if self._concealed >= _MAX_CONCEALED:
            self._next = None
            return None
        return self._conceal(self._next, _STEP)

    @property
    def _base_s(self) -> float:
        return min(transit_s for _, transit_s in self._transits)

    def _measured_s(self) -> float:
        """Return the 95th percentile of lateness behind the fastest packet, within the bounds."""
        transits = sorted(transit_s for _, transit_s in self._transits)
        slow_s = transits[-1 - len(transits) // 20] - transits[0]
        if len(transits) < 20:  # with too few packets the earlier estimate still counts
            slow_s = max(slow_s, self._jitter_s - _LEAST_S)
        return min(slow_s + _LEAST_S, _MOST_S)

    def _unwrapped(self, packet: VoicePacket, now_s: float) -> int:
        """Return the timestamp unwrapped from 32 bits; restart where it has jumped."""
        ahead = (packet.timestamp - self._newest + _UINT32 // 2) % _UINT32 - _UINT32 // 2
        is_other = packet.source != self._source or abs(ahead) > _MAX_AHEAD
        if is_other or now_s - self._came_s > _PAUSE_S:
            self._packets.clear()
            self._transits.clear()
            self._next = None
            self._source = packet.source
            # Start one wrap later than everything before, so that times only grow.
            self._newest = packet.timestamp + (self._newest // _UINT32 + 1) * _UINT32
            self._played_to = min(self._newest, self._played_to)
            return self._newest
        at = self._newest + ahead
        self._newest = max(self._newest, at)
        return at

    def _conceal(self, at: int, samples: int) -> Missing:
        self._next = at + samples
        self._concealed += samples
        return Missing(samples)

    def _is_skipped(self, packet: VoicePacket, now_s: float) -> bool:
        """Return whether to skip this packet, so that the rest is heard sooner."""
        length_s = packet.samples / RATE_HZ
        late_s = self._offset_s - (self._base_s + self._jitter_s)
        if late_s < length_s + _TOO_LATE_S or now_s - self._skipped_s < _SKIP_EVERY_S:
            return False
        self._skipped_s = now_s
        self._offset_s -= length_s
        return True
