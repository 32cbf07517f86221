"""What a receiver of pictures asks for again, and when it gives up and wants a keyframe.

After Chromium's: a packet that is missing is asked for at once and again each round trip, ten times
at most; a picture that cannot be completed ends in asking for a keyframe.
"""

from __future__ import annotations

from typing import Final

AGAIN_S: Final = 0.1
"""In the place of the round trip, which a receiver does not know; Chromium begins with it too."""
MOST_TIMES: Final = 10
MOST_MISSING: Final = 1000
KEYFRAME_EVERY_S: Final = 0.3


class Missing:
    """The gaps of one stream. Times are monotonic seconds; pure."""

    def __init__(self) -> None:
        self._newest: int | None = None
        self._asked: dict[int, tuple[int, float]] = {}
        self._wants_keyframe = False
        self._keyframe_s = -KEYFRAME_EVERY_S

    def came(self, sequence: int) -> None:
        """Take a packet's 16 bits."""
        if self._newest is None:
            self._newest = sequence
            return
        ahead = (sequence - self._newest + 0x8000) % 0x10000 - 0x8000
        if ahead <= 0:
            self._asked.pop(sequence, None)
            return
        if ahead + len(self._asked) > MOST_MISSING:
            self._asked.clear()
            self._wants_keyframe = True
        else:
            for one in range(1, ahead):
                self._asked[(self._newest + one) & 0xFFFF] = (0, -AGAIN_S)
        self._newest = sequence

    def due(self, now_s: float) -> tuple[list[int], bool]:
        """Return what to ask for now, and whether to ask for a keyframe."""
        found = []
        for sequence, (times, at_s) in list(self._asked.items()):
            if now_s - at_s < AGAIN_S:
                continue
            if times == MOST_TIMES:
                del self._asked[sequence]
                self._wants_keyframe = True
                continue
            self._asked[sequence] = (times + 1, now_s)
            found.append(sequence)
        wants = self._wants_keyframe and now_s - self._keyframe_s >= KEYFRAME_EVERY_S
        if wants:
            self._wants_keyframe, self._keyframe_s = False, now_s
        return found, wants
