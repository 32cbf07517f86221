"""Time for those who only ask for it."""

from __future__ import annotations

from typing import Protocol

from wax.clock import Clock


class Turnable(Clock, Protocol):
    """A clock that a test sets."""

    time_s: float


class TurnedClock:
    """A clock that stands until it is turned."""

    def __init__(self, time_s: float = 1000.0) -> None:
        self.time_s = time_s

    def now_s(self) -> float:
        return self.time_s

    def wall_ms(self) -> int:
        return 0
