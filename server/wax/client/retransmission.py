"""Requests retransmissions of a picture's packets, and keyframes (pure).

As in Chromium: a missing packet is asked for at once and again each round trip, ten times at
most; a frame that cannot be completed ends in a request for a keyframe.
"""

from __future__ import annotations

from typing import Final

RETRY_S: Final = 0.1
"""Replaces the round trip, which this receiver does not know; Chromium starts with it too."""
MAX_RETRIES: Final = 10
MAX_MISSING: Final = 1000
KEYFRAME_INTERVAL_S: Final = 0.3


class RetransmissionRequests:
    """The gaps of one stream; times are s of a monotonic clock."""

    def __init__(self) -> None:
        self._newest: int | None = None
        self._asked: dict[int, tuple[int, float]] = {}
        self._wants_keyframe = False
        self._keyframe_s = -KEYFRAME_INTERVAL_S

    @property
    def is_empty(self) -> bool:
        """Whether nothing is missing and no keyframe is wanted."""
        return not self._asked and not self._wants_keyframe

    def arrived(self, sequence: int) -> None:
        """Count a packet's 16-bit number, retransmitted or not."""
        if self._newest is None:
            self._newest = sequence
            return
        ahead = (sequence - self._newest + 0x8000) % 0x10000 - 0x8000
        if ahead <= 0:
            self._asked.pop(sequence, None)
            return
        if ahead + len(self._asked) > MAX_MISSING:
            self._asked.clear()
            self._wants_keyframe = True
        else:
            for one in range(1, ahead):
                self._asked[(self._newest + one) & 0xFFFF] = (0, -RETRY_S)
        self._newest = sequence

    def due(self, now_s: float) -> tuple[list[int], bool]:
        """Return the packets to request now, and whether to request a keyframe."""
        found = []
        for sequence, (times, at_s) in list(self._asked.items()):
            if now_s - at_s < RETRY_S:
                continue
            if times == MAX_RETRIES:
                del self._asked[sequence]
                self._wants_keyframe = True
                continue
            self._asked[sequence] = (times + 1, now_s)
            found.append(sequence)
        wants = self._wants_keyframe and now_s - self._keyframe_s >= KEYFRAME_INTERVAL_S
        if wants:
            self._wants_keyframe, self._keyframe_s = False, now_s
        return found, wants
