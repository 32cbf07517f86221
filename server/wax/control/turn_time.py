"""The time of one turn, which stands still while something keeps its operator from driving.

It does while the robot cannot be driven, its camera delivers nothing, or somebody else has pressed
Stop; for at most `MAX_PAUSE_S` a turn, so that nobody holds up the queue by pressing Stop.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

MAX_PAUSE_S: Final = 60.0


@dataclass(frozen=True, slots=True)
class TurnTime:
    """At `since_s` there were `left_s` to drive; it may stand still for `pause_left_s` more."""

    since_s: float
    left_s: float
    pause_left_s: float = MAX_PAUSE_S
    is_paused: bool = False

    @property
    def ends_s(self) -> float:
        """The latest end: while it stands still, as if it did so for as long as it may."""
        return self.since_s + self.left_s + (self.pause_left_s if self.is_paused else 0.0)

    def left_at(self, now_s: float) -> float:
        """Return the seconds left to drive."""
        return self.left_s - (now_s - self.since_s) + self._stood_s(now_s)

    def stands_at(self, now_s: float) -> bool:
        """Whether it stands still now."""
        return self.is_paused and now_s - self.since_s < self.pause_left_s

    def paused(self, is_paused: bool, now_s: float) -> TurnTime:
        """Let it stand still or go on from now."""
        if is_paused == self.is_paused:
            return self
        pause_left_s = self.pause_left_s - self._stood_s(now_s)
        return TurnTime(now_s, self.left_at(now_s), pause_left_s, is_paused)

    def _stood_s(self, now_s: float) -> float:
        return min(self.pause_left_s, now_s - self.since_s) if self.is_paused else 0.0
