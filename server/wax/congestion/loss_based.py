"""Rate control by loss alone, for a browser or a stream without transport-wide feedback. Pure.

The loss-based half of Google's congestion control (draft-ietf-rmcat-gcc-02, section 6). It notices
a full link only when its queue overflows.
"""

from __future__ import annotations

from math import inf
from typing import Final

from wax.congestion.probing import ENOUGH_BPS

_STARTING_RATE_BPS: Final = 5_000_000.0
"""Rate before the first report. Ours: no delay would show that it is too high."""
_MIN_RATE_BPS: Final = 30_000.0
"""Lowest rate: sound, and the smallest picture now and then."""
LOW_LOSS_SHARE: Final = 0.02
"""Less loss is no congestion. GCC: 2 %."""
_HIGH_LOSS_SHARE: Final = 0.10
"""Above this share it falls. GCC: 10 %."""
_INCREASE_PER_S: Final = 0.08
"""Increase per second. GCC: 5 % a report."""
_MAX_REPORT_S: Final = 2.0
"""One report counts for at most this long. Ours: twice a browser's interval."""
_DECREASE_SHARE: Final = 0.5
"""The rate falls by this fraction of the lost share. GCC: 1 - 0.5 p."""


class LossBasedControl:
    """Follows the lost share in each receiver report (RFC 3550, 6.4.1); `now_s` never falls."""

    def __init__(self, rate_bps: float = _STARTING_RATE_BPS, max_bps: float = ENOUGH_BPS) -> None:
        """Start with a known rate and bound, or with those of an unknown link."""
        self._max_bps = max_bps
        self.rate_bps = rate_bps
        self._reported_s: float | None = None

    def reported(self, lost: float, now_s: float, came_bps: float = inf) -> None:
        """Handle a share from 0 to 1; after a high one, no more than `came_bps` got through."""
        before_s = now_s if self._reported_s is None else self._reported_s
        self._reported_s = now_s
        if lost > _HIGH_LOSS_SHARE:
            self._set(min(self.rate_bps * (1 - _DECREASE_SHARE * lost), came_bps))
        elif lost < LOW_LOSS_SHARE:
            elapsed_s = min(now_s - before_s, _MAX_REPORT_S)
            self._set(self.rate_bps * (1 + _INCREASE_PER_S * elapsed_s))

    def _set(self, rate_bps: float) -> None:
        self.rate_bps = min(max(rate_bps, _MIN_RATE_BPS), self._max_bps)
