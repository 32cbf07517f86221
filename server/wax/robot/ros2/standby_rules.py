"""When a standby sends standstill for the driver, and when it counts as dead itself (pure)."""

from __future__ import annotations

import math
from typing import Final

OWES: Final = b"w"
"""The driver's message if the robot moves, or may not have received standstill."""
RESTS: Final = b"r"
"""The driver's message once standstill has been sent for long enough."""
SILENCE_S: Final = 0.12
"""The timeout for a driver that owes standstill; it sends at least 20 messages a second."""

MUTE_S: Final = 1.0
"""The timeout for a standby that reaches a subscriber; it reports ten times a second, or less often
when many nodes appear at once."""
START_S: Final = 20.0
"""The same while it starts or connects: Python and DDS take long on a small computer."""


def patience_s(reaches: int | None, reopen_s: float) -> float:
    """Return the standby's timeout, given how many subscribers it has reported, if any."""
    return START_S + reopen_s if reaches == 0 else MUTE_S


class StandbyRules:
    """Sends while a driver that owes standstill is silent, and for `zeros_s` after its end."""

    def __init__(self, *, rate_hz: float, zeros_s: float) -> None:
        self._period_s = 1.0 / rate_hz
        self._zeros_s = zeros_s
        self._silent_at_s = math.inf
        self._ends_s = math.inf
        self._next_s = -math.inf

    def handle_reports(self, words: bytes, now_s: float) -> None:
        """Handle the driver's messages; only the last one counts."""
        self._silent_at_s = now_s + SILENCE_S if words[-1:] == OWES else math.inf

    def ended(self, now_s: float) -> None:
        """Take over, because the driver was closed or died: the robot may still move."""
        self._ends_s = min(self._ends_s, now_s + self._zeros_s)

    def is_over(self, now_s: float) -> bool:
        return now_s >= self._ends_s

    def next(self, now_s: float) -> tuple[bool, float]:
        """Return whether to send standstill now, and the latest time of the next call."""
        if math.isinf(self._ends_s) and now_s < self._silent_at_s:
            return False, self._silent_at_s
        if now_s < self._next_s:
            return False, self._next_s
        # On time means from when it was due, so that a late wake-up does not slow it down.
        late_s = now_s - self._next_s
        self._next_s = (now_s if late_s > self._period_s else self._next_s) + self._period_s
        return True, self._next_s
