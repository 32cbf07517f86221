"""How much all observers together are sent while the event loop is late. Pure.

Each packet takes the loop some time. On a machine too slow for its viewers, the operator's commands
and the observers' Stop would wait behind the observers' pictures; so these are cut until the loop
is on time, and grow again slowly (additive increase, multiplicative decrease, as in RFC 5681).
"""

from __future__ import annotations

import math
from typing import Final

_LATE_S: Final = 0.015
"""The loop is late if its ticks or its peers' datagrams are, on the mean of a second."""
_ON_TIME_S: Final = 0.008
"""With a mean delay between the two the limit stays."""
_CUT: Final = 0.8
"""What a late second leaves: three of them halve the load, or one that is three times as late."""
_STEP: Final = 0.03
"""Growth per second, as a part of what the observers want: half a minute from nothing to all."""
_LEAST_BPS: Final = 100_000
"""For each observer; sound and a small picture."""


class MeanDelay:
    """The mean of delays of which the number and the sum since the start are known."""

    def __init__(self) -> None:
        self._count, self._sum_s = 0, 0.0

    def since_last(self, count: int, sum_s: float) -> float:
        """Return the mean since the last call in s, 0 if there was none."""
        new, new_s = count - self._count, sum_s - self._sum_s
        self._count, self._sum_s = count, sum_s
        return new_s / max(new, 1)


class LateLoop:
    """Call `update` once a second."""

    def __init__(self) -> None:
        self.most_bps = math.inf
        """The limit for all observers together."""

    def update(self, late_s: float, *, wanted_bps: float, observers: int) -> None:
        """Take the mean delay of the last second, in s.

        `wanted_bps` is what the observers' links would carry, without this limit.
        """
        if late_s > _LATE_S and observers:
            cut_bps = _CUT ** (late_s / _LATE_S) * min(self.most_bps, wanted_bps)
            self.most_bps = max(cut_bps, _LEAST_BPS * observers)
            return
        if late_s < _ON_TIME_S:
            self.most_bps += _STEP * wanted_bps
        if self.most_bps >= wanted_bps:
            self.most_bps = math.inf
