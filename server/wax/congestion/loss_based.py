"""What a link carries, where a browser tells of nothing but how much it has lost. Pure.

The loss-based half of Google's congestion control (draft-ietf-rmcat-gcc-02, section 6), for what
has no transport-wide feedback. It notices a full link only when its queue overflows.
"""

from __future__ import annotations

from math import isfinite
from typing import Final

_START_BPS: Final = 5_000_000.0
_LEAST_BPS: Final = 30_000.0
_MOST_BPS: Final = 20_000_000.0
_FEW: Final = 0.02
_MANY: Final = 0.10
_RISE_PER_S: Final = 0.08
_MOST_S: Final = 2.0


class LossBasedControl:
    """Follows the share of packets that each receiver report tells (RFC 3550, 6.4.1)."""

    def __init__(self) -> None:
        self.rate_bps = _START_BPS
        self.lost = 0.0
        """The share that the newest report told."""
        self._reported_s: float | None = None

    def reported(self, lost: float, now_s: float) -> None:
        """Learn a share from 0 to 1; what is none, and time that runs back, changes nothing."""
        if not (isfinite(lost) and 0 <= lost <= 1 and isfinite(now_s)):
            return
        before_s = now_s if self._reported_s is None else self._reported_s
        self._reported_s = max(before_s, now_s)
        self.lost = lost
        if lost > _MANY:
            self._set(self.rate_bps * (1 - lost / 2))
        elif lost < _FEW:
            elapsed_s = min(max(now_s - before_s, 0.0), _MOST_S)
            self._set(self.rate_bps * (1 + _RISE_PER_S * elapsed_s))

    def _set(self, rate_bps: float) -> None:
        self.rate_bps = min(max(rate_bps, _LEAST_BPS), _MOST_BPS)
