"""When a standby sends standstill in the driver's place, and when it is taken for dead (pure)."""

from __future__ import annotations

import math
from typing import Final

OWES: Final = b"w"
"""What the driver says with each message: the robot moves, or may not have heard that it stands."""
RESTS: Final = b"r"
"""The robot was told long enough to stand."""
SILENCE_S: Final = 0.12
"""How long a driver that owes standstill may say nothing; it says so 20 times a second and more."""

MUTE_S: Final = 1.0
"""How long a standby that reaches somebody may say nothing; it speaks ten times a second, or
later where many nodes appear at once."""
START_S: Final = 20.0
"""The same where it connects, or starts: Python and DDS take long on a small computer."""


def patience_s(reaches: int | None, reopen_s: float) -> float:
    """Return how long the standby may say nothing; it has said how many it reaches, if it knows."""
    return START_S + reopen_s if reaches == 0 else MUTE_S


class StandbyRules:
    """Sends while a driver that owes standstill is silent, and for `zeros_s` after it has ended."""

    def __init__(self, *, rate_hz: float, zeros_s: float) -> None:
        self._period_s = 1.0 / rate_hz
        self._zeros_s = zeros_s
        self._silent_at_s = math.inf
        self._ends_s = math.inf
        self._next_s = -math.inf

    def hear(self, words: bytes, now_s: float) -> None:
        """Take what the driver says; only the last word counts."""
        self._silent_at_s = now_s + SILENCE_S if words[-1:] == OWES else math.inf

    def ended(self, now_s: float) -> None:
        """Take over: the driver was closed, or has died. Whatever it said, the robot may move."""
        self._ends_s = min(self._ends_s, now_s + self._zeros_s)

    def is_over(self, now_s: float) -> bool:
        return now_s >= self._ends_s

    def next(self, now_s: float) -> tuple[bool, float]:
        """Return whether to send standstill now, and when to ask again at the latest."""
        if math.isinf(self._ends_s) and now_s < self._silent_at_s:
            return False, self._silent_at_s
        if now_s < self._next_s:
            return False, self._next_s
        # On time means from when it was due, so that a late wake-up does not slow it down.
        late_s = now_s - self._next_s
        self._next_s = (now_s if late_s > self._period_s else self._next_s) + self._period_s
        return True, self._next_s
