"""What the operator's hands say: one complete set-point."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from collections.abc import Mapping


@dataclass(frozen=True, slots=True)
class Command:
    """A complete set-point of the operator's hands.

    `linear` and `angular` are shares of the limits in -1…1 (ahead and left are positive), `held`
    is the dead-man, `axes` positions in -1…1 of those that have a hand on them now. `sent_s` and
    `seen_s` (the capture time of the newest presented picture, None while there is none) are on the
    server's clock.
    """

    seq: int
    turn: int
    sent_s: float
    linear: float
    angular: float
    held: bool
    speed: Literal["slow", "fast"]
    seen_s: float | None = None
    axes: Mapping[str, float] = field(default_factory=dict)

    @property
    def asks_for_motion(self) -> bool:
        """Some share is not zero; an axis is no motion of the robot."""
        return self.linear != 0 or self.angular != 0

    @property
    def is_neutral(self) -> bool:
        """All is let go of: no motion is asked for, and the dead-man is not held either.

        Neither two keys that cancel each other, nor a hand on an axis, nor a dead-man taped down
        is neutral.
        """
        return not self.asks_for_motion and not self.held

    @property
    def is_in_range(self) -> bool:
        """Every number is finite and within its bounds; `seen_s` is `sight`'s to judge."""
        shares = (self.linear, self.angular, *self.axes.values())
        return math.isfinite(self.sent_s) and all(-1 <= share <= 1 for share in shares)
