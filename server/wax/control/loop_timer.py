"""When the loop's next tick is due, and how late recent ticks were. Pure."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import deque
from typing import Final

MAX_LATE_S: Final = 0.2
MIN_LATE_S: Final = 0.1
_EARLY_S: Final = 0.001
"""A step this close before a tick counts as that tick: timers may fire a little early."""
_REMEMBERED_S: Final = 60.0

BOUNDS_MS: Final = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 40.0, 100.0, 200.0)


class Lateness:
    """How late the ticks have been since the start, for monitoring.

    `counts` has a bucket up to each bound of `BOUNDS_MS`, and one for everything above.
    """

    def __init__(self) -> None:
        self.counts = [0] * (len(BOUNDS_MS) + 1)
        self.sum_s = 0.0

    def add(self, late_s: float) -> None:
        self.counts[bisect_left(BOUNDS_MS, late_s * 1000)] += 1
        self.sum_s += late_s


class LoopTimer:
    """A schedule that never drifts: a late tick does not delay the next one.

    A tick is *too* late after `ttl_s`, when the robot's own watchdog has stopped it (None if
    unknown): a robot that stopped itself must not restart unasked. The limit is at most
    `MAX_LATE_S`, and at least `MIN_LATE_S`: less would stop the robot for every hiccup of a busy
    computer, and commands that are too old are refused anyway. Delays are kept for a minute.
    """

    def __init__(self, *, loop_hz: float, ttl_s: float | None) -> None:
        self.period_s = 1 / loop_hz
        self._max_late_s = MAX_LATE_S
        if ttl_s is not None:
            self._max_late_s = min(MAX_LATE_S, max(MIN_LATE_S, ttl_s))
        self._due_s: float | None = None  # None before the first tick
        self.lateness = Lateness()
        self._most = math.ceil(_REMEMBERED_S * loop_hz)
        self._late_s: deque[float] = deque(maxlen=self._most)

    def is_too_late(self, now_s: float) -> bool:
        """Record a step at `now_s`, which may also come between two ticks."""
        due_s = now_s if self._due_s is None else self._due_s
        late_s = now_s - due_s
        if late_s >= -_EARLY_S:
            missed = math.floor(max(0.0, late_s) / self.period_s)
            self._due_s = due_s + self.period_s * (missed + 1)
            # The ticks that were skipped were late as well.
            for tick in range(min(missed + 1, self._most)):
                self._late_s.append(max(0.0, late_s - tick * self.period_s))
            self.lateness.add(max(0.0, late_s))
        return late_s > self._max_late_s

    def rest_s(self, now_s: float) -> float:
        """Return the time until the next tick."""
        return 0.0 if self._due_s is None else max(0.0, self._due_s - now_s)

    @property
    def jitter_p99_ms(self) -> float:
        """The 99th percentile of how late the ticks of the last minute were."""
        return self._late_ms(0.99)

    @property
    def latest_ms(self) -> float:
        """How late the latest tick of the last minute was."""
        return self._late_ms(1.0)

    def _late_ms(self, share: float) -> float:
        late_s = sorted(self._late_s)
        return late_s[math.ceil(share * len(late_s)) - 1] * 1000 if late_s else 0.0
