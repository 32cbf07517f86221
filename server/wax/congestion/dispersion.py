"""What the trains of the last while say about the link, and how sure that is.

A train that is sent faster than the link carries comes out at the rate of the link. Jitter
makes one train say little, so the time they took together is taken over their bits together,
with as many standard errors on either side as may be wrong.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final, NamedTuple

_MEMORY_S: Final = 10.0
_MOST: Final = 128
_ERRORS: Final = 2.0
_BOLD_ERRORS: Final = 0.7
_WISER: Final = 0.1
_PRIOR: Final = 3
_LIKELY_ERRORS: Final = 1.5
_FEW: Final = 16
_MANY: Final = 32


class TrainDispersion(NamedTuple):
    """One train: its bits after the first packet, and the times from first to last packet."""

    judged_s: float
    bits: float
    sent_in_s: float
    came_in_s: float


class _Sums(NamedTuple):
    """Of all trains until one of them, itself among them; bits in thousands, times in ms."""

    judged_s: float
    bits: float
    ms: float
    bits_2: float
    bits_ms: float
    ms_2: float


_NONE: Final = _Sums(-math.inf, 0.0, 0.0, 0.0, 0.0, 0.0)


class DispersionEstimator:
    """PacketTrains that were paced faster than the rate that was known; each question is cheap."""

    def __init__(self) -> None:
        self._sums: deque[_Sums] = deque([_NONE])

    def add(self, passage: TrainDispersion, rough_s: float) -> None:
        """Count a train; one that came in less time than it was sent in was held and let go."""
        while len(self) and self._sums[1].judged_s < passage.judged_s - _MEMORY_S:
            self._sums.popleft()
        if passage.came_in_s < 0.9 * passage.sent_in_s - 2 * rough_s:
            return
        if len(self) >= _MOST:
            self._sums.popleft()
        last = self._sums[-1]
        bits = passage.bits / 1000
        ms = max(passage.came_in_s, passage.sent_in_s) * 1000
        self._sums.append(
            _Sums(
                passage.judged_s,
                last.bits + bits,
                last.ms + ms,
                last.bits_2 + bits * bits,
                last.bits_ms + bits * ms,
                last.ms_2 + ms * ms,
            )
        )

    def __len__(self) -> int:
        return len(self._sums) - 1

    def clear(self) -> None:
        self._sums = deque([_NONE])

    def least_bps(self, rough_s: float, *, bold: bool) -> float:
        """Return what the link carries at least: the best that the last 1, 2, 4… trains show.

        `bold` is for the first trains, when it matters more to be soon than to be sure.
        """
        errors = _ERRORS
        if bold:
            errors = min(_BOLD_ERRORS + _WISER * len(self), _ERRORS)
        least_bps, count = 0.0, 1
        while len(self) and count < 2 * len(self):
            least_bps = max(least_bps, self._bound_bps(min(count, len(self)), rough_s, errors))
            count *= 2
        return least_bps

    def likely_bps(self, rough_s: float) -> float:
        """Return what the link may well carry; of few trains nothing."""
        if len(self) < _FEW:
            return 0.0
        return self._bound_bps(len(self), rough_s, -_LIKELY_ERRORS)

    def most_bps(self, rough_s: float) -> float:
        """Return what the link carries at most; only many trains limit it."""
        if len(self) < _MANY:
            return math.inf
        return self._bound_bps(len(self), rough_s, -_ERRORS)

    def _bound_bps(self, count: int, rough_s: float, errors: float) -> float:
        """Return the rate of the last `count` trains, so many standard errors below it."""
        last, first = self._sums[-1], self._sums[-1 - count]
        bits, ms = last.bits - first.bits, last.ms - first.ms
        slowness = ms / bits
        # A few trains say little about how much they differ, so what single packets say counts too.
        squares = _PRIOR * 2 * (rough_s * 1000) ** 2
        squares += max(
            0.0,
            (last.ms_2 - first.ms_2)
            - 2 * slowness * (last.bits_ms - first.bits_ms)
            + slowness**2 * (last.bits_2 - first.bits_2),
        )
        ms += errors * math.sqrt(squares / (count + _PRIOR - 1)) * math.sqrt(count)
        return bits / ms * 1e6 if ms > 0 else math.inf
