"""When to send set-points (pure): changes at once, motion steadily, standstill for a while."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wax.driver.interface import Twist


class Pace:
    """Sends motion at `rate_hz`, and after it standstill at that rate for `zeros_s`.

    A robot may lack a timeout, and a message may be lost: so standstill is repeated, after
    `zeros_s` at `idle_hz`; 0 leaves the topic to others.
    """

    def __init__(self, *, rate_hz: float, zeros_s: float, idle_hz: float) -> None:
        self._period_s = 1.0 / rate_hz
        self._zeros_s = zeros_s
        self._idle_s = 1.0 / idle_hz if idle_hz > 0.0 else math.inf
        self.begin()

    def begin(self) -> None:
        """Start over, as on a new connection: standstill is sent for its full duration."""
        self._newest: Twist | None = None
        self._sent_s = -math.inf
        self._stands_s = math.inf

    def stopped(self, now_s: float) -> None:
        """Handle a stop: if standstill was sent last, send it for its full duration again.

        Its rate stays, so frequent calls do not flood the topic.
        """
        if math.isfinite(self._stands_s):
            self._stands_s = now_s

    def next(self, twist: Twist, now_s: float, *, alone: bool = True) -> tuple[bool, float]:
        """Return whether to send `twist` now, and the latest time of the next call.

        While we are not `alone` on the topic, standstill is not repeated beyond `zeros_s`: it would
        conflict with another publisher's commands.
        """
        is_news = self._newest is None or twist != self._newest
        if is_news:
            self._stands_s = now_s if twist.is_zero else math.inf
        elif now_s < (due_s := self._due_s(now_s, alone=alone)):
            return False, due_s
        # On time means from the last one's due time, so that a late wake-up does not slow it down.
        on_time_s = self._sent_s + self._period_s
        is_late = is_news or now_s - on_time_s > self._period_s
        self._newest, self._sent_s = twist, now_s if is_late else on_time_s
        return True, self._due_s(now_s, alone=alone)

    def owes(self, now_s: float) -> bool:
        """Whether the robot moves, or standstill has not been sent for long enough."""
        return now_s - self._stands_s < self._zeros_s

    def _due_s(self, now_s: float, *, alone: bool) -> float:
        if self.owes(now_s):
            return self._sent_s + self._period_s
        return self._sent_s + self._idle_s if alone else math.inf
