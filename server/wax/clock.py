"""One monotonic clock for every measurement; wall time only for people and the test card.

It includes the time that the machine sleeps: after a resume, commands, pictures and control loop
ticks have their true age, so nothing moves until all controls have been released.

Pure code takes ``now_s`` as an argument; its caller has a `Clock` from the composition root.
"""

from __future__ import annotations

import sys
import time
from typing import Final, Protocol

_COUNTS_SLEEP: Final = {"linux": "CLOCK_BOOTTIME", "darwin": "CLOCK_MONOTONIC_RAW"}
"""For systems whose `time.monotonic` stops during sleep: the clock that does not (clock_gettime).

Linux's ``CLOCK_MONOTONIC_RAW`` stops too. Elsewhere `time.monotonic` is the best available; on
Windows it includes sleep.
"""


class Clock(Protocol):
    """A source of time, injected so that tests can turn it by hand."""

    def now_s(self) -> float:
        """Monotonic seconds, asleep or awake; "server time" is this clock, in ms on the wire."""
        ...

    def wall_ms(self) -> int:
        """Unix time in whole milliseconds, for people and the test card only."""
        ...


class SystemClock:
    """The machine's own clocks."""

    def __init__(self, platform: str = sys.platform) -> None:
        self._counts_sleep: int | None = getattr(time, _COUNTS_SLEEP.get(platform, ""), None)

    def now_s(self) -> float:
        if self._counts_sleep is None:
            return time.monotonic()
        return time.clock_gettime(self._counts_sleep)

    def wall_ms(self) -> int:
        return time.time_ns() // 1_000_000


UNIX_ZERO_S: Final = SystemClock().wall_ms() / 1000 - SystemClock().now_s()
"""The Unix time of `now_s` 0, as measured when the process started: for times that must not jump
when somebody sets the clock, such as the capture times of sound and picture."""
