"""Clocks that advance only when a test turns them."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Protocol

from wax.clock import Clock

if TYPE_CHECKING:
    import pytest


class Turnable(Clock, Protocol):
    """A clock that a test sets."""

    time_s: float


class TurnedClock:
    """A clock that stands still until it is turned."""

    def __init__(self, time_s: float = 1000.0) -> None:
        self.time_s = time_s
        self.wall = 0

    def now_s(self) -> float:
        return self.time_s

    def wall_ms(self) -> int:
        return self.wall


def turn_loop(by_s: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Advance the running event loop's clock by this much: timers due by then are due now."""
    loop = asyncio.get_running_loop()
    time_s = loop.time
    monkeypatch.setattr(loop, "time", lambda: time_s() + by_s)
