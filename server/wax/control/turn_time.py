"""The clock of one turn, which pauses while something keeps the operator from driving.

It pauses while the robot cannot be driven, its camera delivers nothing, or somebody else's Stop is
in force; for at most `MAX_PAUSE_S` a turn, so that nobody can hold up the queue by pressing Stop.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

MAX_PAUSE_S: Final = 60.0


@dataclass(frozen=True, slots=True)
class TurnTime:
    """At `since_s` there were `left_s` to drive; `pause_left_s` is how long it may still pause."""

    since_s: float
    left_s: float
    pause_left_s: float = MAX_PAUSE_S
    is_paused: bool = False

    @property
    def ends_s(self) -> float:
        """The latest possible end: a pause is assumed to last for as long as it may."""
        return self.since_s + self.left_s + (self.pause_left_s if self.is_paused else 0.0)

    def left_at(self, now_s: float) -> float:
        """Return the seconds left to drive."""
        return self.left_s - (now_s - self.since_s) + self._paused_s(now_s)

    def is_paused_at(self, now_s: float) -> bool:
        """Whether the clock is paused now."""
        return self.is_paused and now_s - self.since_s < self.pause_left_s

    def paused(self, is_paused: bool, now_s: float) -> TurnTime:
        """Pause or resume the clock from now."""
        if is_paused == self.is_paused:
            return self
        pause_left_s = self.pause_left_s - self._paused_s(now_s)
        return TurnTime(now_s, self.left_at(now_s), pause_left_s, is_paused)

    def _paused_s(self, now_s: float) -> float:
        return min(self.pause_left_s, now_s - self.since_s) if self.is_paused else 0.0
