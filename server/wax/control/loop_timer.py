"""The beat of the loop: when it is due, and how late it was of late. Pure."""

from __future__ import annotations

import math
from collections import deque
from typing import Final

MAX_LATE_S: Final = 0.2
MIN_LATE_S: Final = 0.1
_EARLY_S: Final = 0.001
"""A step that comes so shortly before a beat is that beat: timers may fire a little early."""
_REMEMBERED_S: Final = 60.0


class LoopTimer:
    """A schedule that never drifts: a beat that is late does not make the next one later.

    A beat is *too* late after the time after which the robot's own watchdog stops it (`ttl_s`, None
    if unknown), so that a robot that has stopped by itself does not start by itself; at most
    `MAX_LATE_S`. Less than `MIN_LATE_S` would stop a robot for every hiccup of a busy computer;
    commands that are too old by then are refused all the same. How late each beat was is remembered
    for a minute.
    """

    def __init__(self, *, loop_hz: float, ttl_s: float | None) -> None:
        self.period_s = 1 / loop_hz
        self._max_late_s = MAX_LATE_S
        if ttl_s is not None:
            self._max_late_s = min(MAX_LATE_S, max(MIN_LATE_S, ttl_s))
        self._due_s: float | None = None  # until the first
        self._late_s: deque[float] = deque(maxlen=math.ceil(_REMEMBERED_S * loop_hz))

    def is_too_late(self, now_s: float) -> bool:
        """Take note of a step at `now_s`, which may also come between two beats."""
        due_s = now_s if self._due_s is None else self._due_s
        late_s = now_s - due_s
        if late_s >= -_EARLY_S:
            missed = math.floor(max(0.0, late_s) / self.period_s)
            self._due_s = due_s + self.period_s * (missed + 1)
            self._late_s.append(max(0.0, late_s))
        return late_s > self._max_late_s

    def rest_s(self, now_s: float) -> float:
        """Return the time until the next beat."""
        return 0.0 if self._due_s is None else max(0.0, self._due_s - now_s)

    @property
    def jitter_p99_ms(self) -> float:
        """By how much 99 of 100 beats of the last minute were late at most."""
        return self._late_ms(0.99)

    @property
    def latest_ms(self) -> float:
        """How late the latest beat of the last minute was."""
        return self._late_ms(1.0)

    def _late_ms(self, share: float) -> float:
        late_s = sorted(self._late_s)
        return late_s[math.ceil(share * len(late_s)) - 1] * 1000 if late_s else 0.0
