"""Rate control by loss alone, for a browser or a stream without transport-wide feedback. Pure.

The loss-based half of Google's congestion control (draft-ietf-rmcat-gcc-02, section 6). It notices
a full link only when its queue overflows.
"""

from __future__ import annotations

from math import inf, isfinite
from typing import Final

_STARTING_RATE_BPS: Final = 5_000_000.0
"""Rate before the first report. Ours: no delay would show that it is too high."""
_MIN_RATE_BPS: Final = 30_000.0
"""Lowest rate: sound, and the smallest picture now and then."""
_MAX_RATE_BPS: Final = 20_000_000.0
"""Highest rate: ten times the largest rendition's."""
_LOW_LOSS_SHARE: Final = 0.02
"""Below this share of lost packets the rate rises. GCC: 2 %."""
_HIGH_LOSS_SHARE: Final = 0.10
"""Above this share it falls. GCC: 10 %."""
_INCREASE_PER_S: Final = 0.08
"""Increase per second. GCC: 5 % a report."""
_MAX_REPORT_S: Final = 2.0
"""One report counts for at most this long. Ours: twice a browser's interval."""
_DECREASE_SHARE: Final = 0.5
"""The rate falls by this fraction of the lost share. GCC: 1 - 0.5 p."""


class LossBasedControl:
    """Follows the lost share in each receiver report (RFC 3550, 6.4.1)."""

    def __init__(
        self, rate_bps: float = _STARTING_RATE_BPS, max_bps: float = _MAX_RATE_BPS
    ) -> None:
        """Start with a known rate and bound, or with those of an unknown link."""
        self._max_bps = max_bps
        self.rate_bps = min(rate_bps, max_bps)
        self._reported_s: float | None = None

    def reported(self, lost: float, now_s: float, came_bps: float = inf) -> None:
        """Handle a share from 0 to 1; an invalid one, or time that runs back, changes nothing.

        After a high loss the rate is no higher than `came_bps`, which got through.
        """
        if not (isfinite(lost) and 0 <= lost <= 1 and isfinite(now_s)):
            return
        before_s = now_s if self._reported_s is None else self._reported_s
        self._reported_s = max(before_s, now_s)
        if lost > _HIGH_LOSS_SHARE:
            self._set(min(self.rate_bps * (1 - _DECREASE_SHARE * lost), came_bps))
        elif lost < _LOW_LOSS_SHARE:
            elapsed_s = min(max(now_s - before_s, 0.0), _MAX_REPORT_S)
            self._set(self.rate_bps * (1 + _INCREASE_PER_S * elapsed_s))

    def _set(self, rate_bps: float) -> None:
        self.rate_bps = min(max(rate_bps, _MIN_RATE_BPS), self._max_bps)
