"""Who is heard: one at a time, whoever began, if they may (pure)."""

from __future__ import annotations

from enum import Enum
from typing import Final

_PAUSE_S: Final = 0.5
"""Who has said nothing for this long has finished."""


class VoiceVerdict(Enum):
    """What becomes of a packet of somebody's voice."""

    HEARD = "heard"
    NOT_ALLOWED = "not allowed"
    MUTED = "muted"
    TAKEN = "taken"
    """Somebody else is speaking."""
    NO_SPEAKER = "no speaker"
    """The robot's speaker does not play."""


class Floor:
    """Gives the floor to one speaker; times are monotonic seconds, speakers viewers' numbers."""

    def __init__(self) -> None:
        self._holder: int | None = None
        self._sounded_s = float("-inf")

    def holder(self, now_s: float) -> int | None:
        """Return who is speaking; None once they have paused."""
        return self._holder if now_s - self._sounded_s < _PAUSE_S else None

    def judge(
        self, who: int, now_s: float, *, may_speak: bool, is_muted: bool, is_played: bool
    ) -> VoiceVerdict:
        """Decide about a packet that has come from `who`, who gets the floor if it is free.

        What they may is asked first: nobody is told more of the room than concerns them.
        """
        if not may_speak:
            self.leave(who)
            return VoiceVerdict.NOT_ALLOWED
        if is_muted:
            self.leave(who)
            return VoiceVerdict.MUTED
        if not is_played:
            return VoiceVerdict.NO_SPEAKER
        if self.holder(now_s) not in (None, who):
            return VoiceVerdict.TAKEN
        if self._holder != who:
            self._holder, self._sounded_s = who, now_s
        return VoiceVerdict.HEARD

    def sounded(self, who: int, now_s: float) -> None:
        """Note that `who` is not silent: silence keeps the floor from nobody."""
        if who == self._holder:
            self._sounded_s = max(self._sounded_s, now_s)

    def leave(self, who: int) -> None:
        """Take the floor from `who`, if they have it."""
        if who == self._holder:
            self.clear()

    def clear(self) -> None:
        """Take the floor from whoever has it."""
        self._holder, self._sounded_s = None, float("-inf")
