"""The operator's command: one complete set-point."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from collections.abc import Mapping


@dataclass(frozen=True, slots=True)
class Command:
    """A complete set-point from the operator's input."""

    seq: int
    turn: int
    sent_s: float
    """On the server's clock, as the page claims."""
    linear: float
    """A fraction of the limit in -1…1; ahead is positive."""
    angular: float
    """A fraction of the limit in -1…1; left is positive."""
    held: bool
    """The dead-man switch."""
    speed: Literal["slow", "fast"]
    seen_s: float | None = None
    """Capture time of the newest picture on screen, as the page claims; None if there is none."""
    axes: Mapping[str, float] = field(default_factory=dict)
    """Positions in -1…1 of the axes being held."""
    heard_s: float = -math.inf
    """When the server sent the newest beat that the page quotes; minus infinity if none."""
    lateral: float = 0.0
    """A fraction of the limit in -1…1; sideways to the left is positive."""

    @property
    def asks_for_motion(self) -> bool:
        """Whether the command moves the robot; moving an axis does not count."""
        return self.linear != 0 or self.angular != 0 or self.lateral != 0

    @property
    def is_neutral(self) -> bool:
        """Whether everything is released: neither motion nor the dead-man.

        Two keys that cancel each other out are not neutral, nor is a dead-man taped down.
        """
        return not self.asks_for_motion and not self.held

    @property
    def is_in_range(self) -> bool:
        """Whether every number is finite and in range; `video_freshness` judges `seen_s`."""
        shares = (self.linear, self.angular, self.lateral, *self.axes.values())
        return math.isfinite(self.sent_s) and all(-1 <= share <= 1 for share in shares)
