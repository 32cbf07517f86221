"""The operator's command: one complete set-point."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from collections.abc import Mapping


@dataclass(frozen=True, slots=True)
class Command:
    """A complete set-point from the operator's input.

    `linear` and `angular` are fractions of the limits in -1…1 (ahead and left are positive), `held`
    is the dead-man switch, `axes` the positions in -1…1 of the axes being held. `sent_s` and
    `seen_s` (the capture time of the newest picture on screen, None if there is none) are on the
    server's clock, as the page claims; `heard_s` is known: when the newest beat was sent that the
    page had heard, minus infinity if it had heard none.
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
    heard_s: float = -math.inf

    @property
    def asks_for_motion(self) -> bool:
        """Whether the command moves the robot; moving an axis does not count."""
        return self.linear != 0 or self.angular != 0

    @property
    def is_neutral(self) -> bool:
        """Whether everything is released: no motion, no dead-man, no axis.

        Two keys that cancel each other out are not neutral, nor is a dead-man taped down.
        """
        return not self.asks_for_motion and not self.held

    @property
    def is_in_range(self) -> bool:
        """Whether every number is finite and in range; `video_freshness` judges `seen_s`."""
        shares = (self.linear, self.angular, *self.axes.values())
        return math.isfinite(self.sent_s) and all(-1 <= share <= 1 for share in shares)
