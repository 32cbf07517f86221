"""When which set-point is sent (pure): a change at once, then steadily; standstill for long."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wax.driver.interface import Twist


class Pace:
    """Decides on sending: motion at `rate_hz`, and after it standstill at that rate for `zeros_s`.

    A robot need not have a time-out, and what says "stop" may be lost: so standstill is repeated,
    and from then on `idle_hz` times a second; 0 means that the topic is left to others.
    """

    def __init__(self, *, rate_hz: float, zeros_s: float, idle_hz: float) -> None:
        self._period_s = 1.0 / rate_hz
        self._zeros_s = zeros_s
        self._idle_s = 1.0 / idle_hz if idle_hz > 0.0 else math.inf
        self.begin()

    def begin(self) -> None:
        """Start over, as on a new connection: standstill is sent for all of its time."""
        self._newest: Twist | None = None
        self._sent_s = -math.inf
        self._stands_s = math.inf

    def stopped(self, now_s: float) -> None:
        """Somebody says stop: where standstill was the last word, say it for all of its time again.

        Its rate stays, so however often this is called, nothing is flooded.
        """
        if math.isfinite(self._stands_s):
            self._stands_s = now_s

    def next(self, twist: Twist, now_s: float, *, alone: bool = True) -> tuple[bool, float]:
        """Return whether to send `twist` now, and when to ask again at the latest.

        While we are not `alone` on the topic, standstill that was said long enough is not repeated:
        it would fight with what somebody else wants.
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
        """Whether the robot moves, or has not been told long enough to stand."""
        return now_s - self._stands_s < self._zeros_s

    def _due_s(self, now_s: float, *, alone: bool) -> float:
        if self.owes(now_s):
            return self._sent_s + self._period_s
        return self._sent_s + self._idle_s if alone else math.inf
