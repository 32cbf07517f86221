"""What keeps choices from flapping: how long more must fit, and longer after each failed trial."""

from __future__ import annotations

import math
from typing import Final

_HOLD_S: Final = 1.0
"""More must have fitted for this long."""
_TRIAL_S: Final = 8.0
"""More that is taken back within this time was too much."""
_FAILED_HOLD_S: Final = 5.0
"""Then more must fit for this long, and twice as long after each further failure."""
_MAX_HOLD_S: Final = 60.0
"""But no longer than this."""


class Since:
    """How long a condition has held without a break."""

    def __init__(self) -> None:
        self._from_s = math.inf

    def lasts(self, so: bool, seconds: float, now_s: float) -> bool:
        """Take one observation; return whether the condition has held for `seconds`."""
        self._from_s = min(self._from_s, now_s) if so else math.inf
        return now_s - self._from_s >= seconds


class Trials:
    """Binary exponential backoff of rises; `now_s` never falls."""

    def __init__(self) -> None:
        self.hold_s = _HOLD_S
        self._rose_s = -math.inf

    @property
    def is_doubtful(self) -> bool:
        """Whether more has lately been too much."""
        return self.hold_s > _HOLD_S

    def rose(self, now_s: float) -> None:
        self._rose_s = now_s

    def fell(self, now_s: float) -> None:
        """Take back what was tried last, if that was lately: the next trial comes later."""
        if now_s - self._rose_s < _TRIAL_S:
            self.hold_s = min(max(2 * self.hold_s, _FAILED_HOLD_S), _MAX_HOLD_S)
        self._rose_s = -math.inf

    def follow(self, now_s: float) -> None:
        """Let what has stayed for long enough have been right."""
        if -math.inf < self._rose_s < now_s - _TRIAL_S:
            self._rose_s, self.hold_s = -math.inf, _HOLD_S
