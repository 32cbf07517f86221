"""How much all observers together are sent while the event loop is late. Pure.

Each packet takes the loop some time. On a machine too slow for its viewers, the operator's commands
would wait behind the observers' pictures; so these are cut until the loop is on time, and grow
again slowly (additive increase, multiplicative decrease, as in RFC 5681).
"""

from __future__ import annotations

import math
from typing import Final

_LATE_S: Final = 0.015
"""The loop is late if its ticks are, on the mean of a second."""
_ON_TIME_S: Final = 0.008
"""With a mean delay between the two the limit stays."""
_CUT: Final = 0.8
"""What a late second leaves: three of them halve the load."""
_STEP: Final = 0.03
"""Growth per second, as a part of what the observers want: half a minute from nothing to all."""
_LEAST_BPS: Final = 100_000
"""For each observer; sound and a small picture."""


class LateLoop:
    """Call `update` once a second."""

    def __init__(self) -> None:
        self.most_bps = math.inf
        """The limit for all observers together."""
        self._ticks, self._sum_s = 0, 0.0

    def update(self, ticks: int, sum_s: float, *, wanted_bps: float, observers: int) -> None:
        """Take the number of ticks since the start, and the sum of their delays in s.

        `wanted_bps` is what the observers' links would carry, without this limit.
        """
        lately, late_s = ticks - self._ticks, sum_s - self._sum_s
        self._ticks, self._sum_s = ticks, sum_s
        mean_s = late_s / max(lately, 1)
        if mean_s > _LATE_S and observers:
            cut_bps = _CUT * min(self.most_bps, wanted_bps)
            self.most_bps = max(cut_bps, _LEAST_BPS * observers)
            return
        if mean_s < _ON_TIME_S:
            self.most_bps += _STEP * wanted_bps
        if self.most_bps >= wanted_bps:
            self.most_bps = math.inf
