"""Keeps choices from flapping: an upgrade must have fitted for a while, longer after failures."""

from __future__ import annotations

import math
from typing import Final

_HOLD_S: Final = 1.0
"""An upgrade must have fitted for this long."""
_TRIAL_S: Final = 8.0
"""An upgrade that is taken back within this time has failed."""
_FAILED_HOLD_S: Final = 5.0
"""After a failure an upgrade must fit for this long, and twice as long after each further one."""
_MAX_HOLD_S: Final = 60.0
"""The longest such time."""


class Since:
    """How long a condition has held without a break."""

    def __init__(self) -> None:
        self._from_s = math.inf

    def lasts(self, so: bool, seconds: float, now_s: float) -> bool:
        """Add one observation; return whether the condition has held for `seconds`."""
        self._from_s = min(self._from_s, now_s) if so else math.inf
        return now_s - self._from_s >= seconds


class Trials:
    """Binary exponential backoff of upgrades; `now_s` never falls."""

    def __init__(self) -> None:
        self.hold_s = _HOLD_S
        self._rose_s = -math.inf

    @property
    def is_doubtful(self) -> bool:
        """Whether an upgrade has failed lately."""
        return self.hold_s > _HOLD_S

    def record_upgrade(self, now_s: float) -> None:
        self._rose_s = now_s

    def record_downgrade(self, now_s: float) -> None:
        """Record a downgrade; if an upgrade was recent, it has failed and the next waits longer."""
        if now_s - self._rose_s < _TRIAL_S:
            self.hold_s = min(max(2 * self.hold_s, _FAILED_HOLD_S), _MAX_HOLD_S)
        self._rose_s = -math.inf

    def settle(self, now_s: float) -> None:
        """Count the last upgrade as a success once it has lasted; this resets the backoff."""
        if -math.inf < self._rose_s < now_s - _TRIAL_S:
            self._rose_s, self.hold_s = -math.inf, _HOLD_S
