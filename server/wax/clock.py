"""One monotonic clock for everything that is measured; wall time only for people and the test card.

Pure code takes ``now_s`` as an argument; whoever calls it gets the value from a `Clock`
that the composition root injected.
"""

from __future__ import annotations

import time
from typing import Protocol


class Clock(Protocol):
    """A source of time, injected so that tests can turn it by hand."""

    def now_s(self) -> float:
        """Monotonic seconds; "server time" is this clock, in ms on the wire."""
        ...

    def wall_ms(self) -> int:
        """Unix time in whole milliseconds, for people and the test card only."""
        ...


class SystemClock:
    """The machine's own clocks."""

    def now_s(self) -> float:
        return time.monotonic()

    def wall_ms(self) -> int:
        return time.time_ns() // 1_000_000
