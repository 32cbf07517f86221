"""Puts one speaker's packets in order, and says when each is due (pure).

A browser's own buffer also stretches sound; here the pauses between words are where the delay
changes, which costs nothing to hear.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Final

from wax.voice.packet import RATE_HZ, VoicePacket

_WINDOW_S: Final = 4.0
"""The delays of this time say how late packets may be."""
_LEAST_S: Final = 0.015
"""Less than this is what the thread that asks may itself be late."""
_MOST_S: Final = 0.2
"""Later than this a voice is no help to who is beside the robot."""
_PAUSE_S: Final = 0.3
"""After such a pause browsers may go on counting where they stopped, so that the delays of before
say nothing."""
_MAX_PACKETS: Final = 64
_MAX_AHEAD: Final = RATE_HZ // 2
"""A jump of the timestamps by more is another beginning."""
_MAX_MADE_UP: Final = RATE_HZ * 60 // 1000
"""A longer gap is a pause, or heard as one."""
_STEP: Final = RATE_HZ // 100
_TOO_LATE_S: Final = 0.02
"""A packet is left out where what follows is so much later than it need be even without it."""
_LEAVE_OUT_EVERY_S: Final = 0.5
_UINT32: Final = 2**32


@dataclass(frozen=True, slots=True)
class Missing:
    """So many samples at 48 kHz are lost, and to be concealed."""

    samples: int


class JitterBuffer:
    """Holds packets until the delays of the last seconds say that they can be played in order.

    Times are monotonic seconds. What is played is in order and nothing is played twice. It holds at
    most 64 packets, whatever comes.
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
        self._made_up = 0
        self._left_out_s = float("-inf")

    @property
    def is_idle(self) -> bool:
        """Whether there is nothing to play until the next packet comes."""
        return self._next is None and not self._packets

    def clear(self) -> None:
        """Forget what waits; what is known of the delays stays."""
        self._packets.clear()
        self._next = None
        self._source = None

    def push(self, packet: VoicePacket, now_s: float) -> None:
        """Take a packet that has come now."""
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
                # It was concealed already, and what follows is here. The next one that
                # is as late shall be waited for.
                self._offset_s = max(self._offset_s, self._base_s + self._jitter_s)
                return
            self._next = None  # all are late now: go on from here, with a longer delay
        self._packets.setdefault(at, packet)
        while len(self._packets) > _MAX_PACKETS:
            del self._packets[min(self._packets)]

    def take(self, now_s: float) -> VoicePacket | Missing | None:
        """Return what is to be played now, None if nothing is due; to be called until it is None.

        What is due is the caller's from then on, and not returned again.
        """
        while self._packets:
            head = min(self._packets)
            at = self._due(head, now_s)
            if at is None:
                return None
            if 0 < head - at <= _MAX_MADE_UP:
                return self._miss(at, min(head - at, _STEP))
            if head > at:
                self._next = None  # a pause, after which the delay may be another
            elif (packet := self._played(head, at, now_s)) is not None:
                return packet
        return self._made_up_at_the_end(now_s)

    def _due(self, head: int, now_s: float) -> int | None:
        """Return where the playing goes on now, or begins; None while that is not due."""
        if self._next is None:
            # Not before now: what is late already would only be found missing again.
            self._offset_s = max(self._base_s + self._jitter_s, now_s - head / RATE_HZ)
            at = head
        else:
            at = self._next
        if now_s < self._offset_s + at / RATE_HZ:
            return None
        if self._next is None:
            self._next, self._made_up = at, 0
        return at

    def _played(self, head: int, at: int, now_s: float) -> VoicePacket | None:
        """Take out the first packet; None if it is not to be heard."""
        packet = self._packets.pop(head)
        if head < at:
            return None  # it overlaps the one before, as no browser's does
        self._next = self._played_to = head + packet.samples
        self._made_up = 0
        return None if self._is_left_out(packet, now_s) else packet

    def _made_up_at_the_end(self, now_s: float) -> Missing | None:
        """Go on for a while when there are no more packets, in case that they are only late."""
        if self._next is None or now_s < self._offset_s + self._next / RATE_HZ:
            return None
        if self._made_up >= _MAX_MADE_UP:
            self._next = None
            return None
        return self._miss(self._next, _STEP)

    @property
    def _base_s(self) -> float:
        return min(transit_s for _, transit_s in self._transits)

    def _measured_s(self) -> float:
        """Return how much later than the fastest the slower packets come, but for the slowest."""
        transits = sorted(transit_s for _, transit_s in self._transits)
        slow_s = transits[-1 - len(transits) // 20] - transits[0]
        if len(transits) < 20:  # until enough is known, what was known before counts
            slow_s = max(slow_s, self._jitter_s - _LEAST_S)
        return min(slow_s + _LEAST_S, _MOST_S)

    def _unwrapped(self, packet: VoicePacket, now_s: float) -> int:
        """Return the timestamp without its wraps; begin anew where it has jumped."""
        ahead = (packet.timestamp - self._newest + _UINT32 // 2) % _UINT32 - _UINT32 // 2
        is_other = packet.source != self._source or abs(ahead) > _MAX_AHEAD
        if is_other or now_s - self._came_s > _PAUSE_S:
            self._packets.clear()
            self._transits.clear()
            self._next = None
            self._source = packet.source
            # A turn of the clock later than all before, so that times only grow.
            self._newest = packet.timestamp + (self._newest // _UINT32 + 1) * _UINT32
            self._played_to = min(self._newest, self._played_to)
            return self._newest
        at = self._newest + ahead
        self._newest = max(self._newest, at)
        return at

    def _miss(self, at: int, samples: int) -> Missing:
        self._next = at + samples
        self._made_up += samples
        return Missing(samples)

    def _is_left_out(self, packet: VoicePacket, now_s: float) -> bool:
        """Whether this packet is left out, so that the rest is heard sooner."""
        length_s = packet.samples / RATE_HZ
        late_s = self._offset_s - (self._base_s + self._jitter_s)
        if late_s < length_s + _TOO_LATE_S or now_s - self._left_out_s < _LEAVE_OUT_EVERY_S:
            return False
        self._left_out_s = now_s
        self._offset_s -= length_s
        return True
