"""When to send set-points (pure): changes at once, and repeats steadily in motion and after a stop.

A line loses messages, and a rover keeps following the last set-point. So after a stop, standstill
is repeated steadily for `STEADY_S`, longer than a radio's usual gap, and then slowly while the line
is open.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from wax.driver.interface import STANDSTILL

if TYPE_CHECKING:
    from wax.driver.interface import Twist

STEADY_S: Final = 2.0
NEUTRAL_EVERY_S: Final = 0.5


class Schedule:
    """The schedule of one line; `gap_s` is the shortest time between two set-points in motion.

    Motion starts at once, even between two repeats of standstill: it waits for the gap only after
    the set-point that began the standstill, so that the line is not flooded.
    """

    def __init__(self, gap_s: float) -> None:
        self._gap_s = gap_s
        self.begin()

    def begin(self) -> None:
        """Start over, as on a new line."""
        self._said: Twist | None = None
        self._said_s = -math.inf
        self._stood_s = -math.inf
        self._steady_until_s = -math.inf

    def is_steady(self, now_s: float) -> bool:
        """Whether a stop was so recent that standstill is still repeated steadily."""
        return now_s < self._steady_until_s

    def stopped(self, now_s: float) -> None:
        """Schedule standstill at once, and steadily for `STEADY_S`."""
        self._said, self._said_s = None, -math.inf
        self._steady_until_s = now_s + STEADY_S

    def next_s(self, wanted: Twist, now_s: float) -> float:
        """Return when to send this, which is now if it is due."""
        if wanted != self._said:
            if wanted.is_zero:
                return now_s
            stands = self._said is not None and self._said.is_zero
            return max(now_s, (self._stood_s if stands else self._said_s) + self._gap_s)
        is_steady = not wanted.is_zero or self.is_steady(now_s)
        return max(now_s, self._said_s + (self._gap_s if is_steady else NEUTRAL_EVERY_S))

    def said(self, wanted: Twist, now_s: float) -> None:
        """Record that this was sent now."""
        if wanted.is_zero and (self._said or STANDSTILL) != wanted:
            self._steady_until_s = now_s + STEADY_S
        if wanted.is_zero and wanted != self._said:
            self._stood_s = now_s
        self._said, self._said_s = wanted, now_s
