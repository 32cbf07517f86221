"""What the trains of the last while say about the link, and how sure that is.

A train that is sent faster than the link carries comes out at the rate of the link. Jitter
makes one train say little, so the time they took together is taken over their bits together,
with as many standard errors on either side as may be wrong.
"""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING, Final, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Sequence

_MEMORY_S: Final = 10.0
_MOST: Final = 128
_ERRORS: Final = 2.0
_BOLD_ERRORS: Final = 0.7
_WISER: Final = 0.1
_PRIOR: Final = 3
_LIKELY_ERRORS: Final = 1.5
_FEW: Final = 16
_MANY: Final = 32


class Passage(NamedTuple):
    """One train: its bits after the first packet, and the times from first to last packet."""

    judged_s: float
    bits: float
    sent_in_s: float
    came_in_s: float


class Evidence:
    """Trains that were paced faster than the rate that was known."""

    def __init__(self) -> None:
        self._passages: deque[Passage] = deque(maxlen=_MOST)

    def add(self, passage: Passage, rough_s: float) -> None:
        """Count a train; one that came in less time than it was sent in was held and let go."""
        while self._passages and self._passages[0].judged_s < passage.judged_s - _MEMORY_S:
            self._passages.popleft()
        if passage.came_in_s < 0.9 * passage.sent_in_s - 2 * rough_s:
            return
        self._passages.append(passage)

    def __len__(self) -> int:
        return len(self._passages)

    def clear(self) -> None:
        self._passages.clear()

    def least_bps(self, rough_s: float, *, bold: bool) -> float:
        """Return what the link carries at least: the best that the last 1, 2, 4… trains show.

        `bold` is for the first trains, when it matters more to be soon than to be sure.
        """
        errors = _ERRORS
        if bold:
            errors = min(_BOLD_ERRORS + _WISER * len(self._passages), _ERRORS)
        trains = list(self._passages)
        least_bps, count = 0.0, 1
        while trains and count < 2 * len(trains):
            least_bps = max(least_bps, _bound_bps(trains[-count:], rough_s, errors))
            count *= 2
        return least_bps

    def likely_bps(self, rough_s: float) -> float:
        """Return what the link may well carry; of few trains nothing."""
        if len(self._passages) < _FEW:
            return 0.0
        return _bound_bps(list(self._passages), rough_s, -_LIKELY_ERRORS)

    def most_bps(self, rough_s: float) -> float:
        """Return what the link carries at most; only many trains limit it."""
        if len(self._passages) < _MANY:
            return math.inf
        return _bound_bps(list(self._passages), rough_s, -_ERRORS)


def _bound_bps(trains: Sequence[Passage], rough_s: float, errors: float) -> float:
    count = len(trains)
    bits = sum(train.bits for train in trains)
    came_in_s = sum(max(train.came_in_s, train.sent_in_s) for train in trains)
    slowness = came_in_s / bits
    # A few trains say little about how much they differ, so what single packets say counts too.
    squares = _PRIOR * 2 * rough_s**2
    squares += sum((train.came_in_s - slowness * train.bits) ** 2 for train in trains)
    error_s = math.sqrt(squares / (count + _PRIOR - 1))
    came_in_s += errors * error_s * math.sqrt(count)
    return bits / max(came_in_s, 1e-6) if came_in_s > 0 else math.inf
