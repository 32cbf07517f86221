"""When a set-point is said (pure): at once when it changes, steadily in motion and after a stop.

A line loses messages, and a rover goes on with what it was told last: so after a stop standstill is
said steadily for `STEADY_S`, longer than a radio's usual gap, and then slowly for as long as the
line is open.
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
    """Decides for one line; `gap_s` is the shortest time between two set-points in motion.

    Motion begins at once, also between two repeats of standstill: it waits for the gap only after
    the set-point that began the standstill, so that the line is not filled.
    """

    def __init__(self, gap_s: float) -> None:
        self._gap_s = gap_s
        self.begin()

    def begin(self) -> None:
        """Start over: what was said before does not matter any more."""
        self._said: Twist | None = None
        self._said_s = -math.inf
        self._stood_s = -math.inf
        self._steady_until_s = -math.inf

    def is_steady(self, now_s: float) -> bool:
        """Whether a stop was so recent that standstill is still said steadily."""
        return now_s < self._steady_until_s

    def stopped(self, now_s: float) -> None:
        """Say standstill at once, and steadily for a while."""
        self._said, self._said_s = None, -math.inf
        self._steady_until_s = now_s + STEADY_S

    def next_s(self, wanted: Twist, now_s: float) -> float:
        """Return when this is to be said, which is now if the time has come."""
        if wanted != self._said:
            if wanted.is_zero:
                return now_s
            stands = self._said is not None and self._said.is_zero
            return max(now_s, (self._stood_s if stands else self._said_s) + self._gap_s)
        is_steady = not wanted.is_zero or self.is_steady(now_s)
        return max(now_s, self._said_s + (self._gap_s if is_steady else NEUTRAL_EVERY_S))

    def said(self, wanted: Twist, now_s: float) -> None:
        """Note that this was said now."""
        if wanted.is_zero and (self._said or STANDSTILL) != wanted:
            self._steady_until_s = now_s + STEADY_S
        if wanted.is_zero and wanted != self._said:
            self._stood_s = now_s
        self._said, self._said_s = wanted, now_s
