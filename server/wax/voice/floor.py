"""Decides who is heard: one permitted speaker at a time, first come, first served (pure)."""

from __future__ import annotations

from enum import Enum
from typing import Final

_PAUSE_S: Final = 0.5
"""A speaker who is silent for this long has finished."""


class VoiceVerdict(Enum):
    """What happens to a packet of somebody's voice."""

    HEARD = "heard"
    NOT_ALLOWED = "not allowed"
    MUTED = "muted"
    TAKEN = "taken"
    """Somebody else is speaking."""
    NO_SPEAKER = "no speaker"
    """The robot's loudspeaker does not play."""


class Floor:
    """Gives the floor to one viewer at a time, by number; times are monotonic seconds."""

    def __init__(self) -> None:
        self._holder: int | None = None
        self._sounded_s = float("-inf")

    def holder(self, now_s: float) -> int | None:
        """Return who has the floor; None once they have paused."""
        return self._holder if now_s - self._sounded_s < _PAUSE_S else None

    def judge(
        self, who: int, now_s: float, *, may_speak: bool, is_muted: bool, is_played: bool
    ) -> VoiceVerdict:
        """Decide about a packet from `who`, and give them the floor if it is free.

        Permission is checked first, so that the verdict tells nobody about others needlessly.
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
        """Record that `who` is not silent; a silent holder loses the floor after the pause."""
        if who == self._holder:
            self._sounded_s = max(self._sounded_s, now_s)

    def leave(self, who: int) -> None:
        """Release the floor if `who` has it."""
        if who == self._holder:
            self.clear()

    def clear(self) -> None:
        """Release the floor, whoever has it."""
        self._holder, self._sounded_s = None, float("-inf")
