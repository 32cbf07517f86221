"""Packet-train dispersion: the bottleneck's rate, from trains that left faster than it.

The bottleneck spreads such a train to its own rate (Keshav's packet pair, SIGCOMM 1991; trains:
Dovrolis, Ramanathan, Moore, INFOCOM 2001). With cross traffic the result is the asymptotic
dispersion rate, between available bandwidth and capacity. Jitter hides most of what one train
shows, so several are summed, times and bits, with a confidence interval in standard errors.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final, NamedTuple

_MEMORY_S: Final = 10.0
"""Older trains do not count. BBR's bandwidth filter is about as long (10 round trips)."""
_MAX_TRAINS: Final = 128
"""Trains kept at most; at 30 pictures a second that is 4 s. Ours."""
_ERRORS: Final = 2.0
"""Standard errors of a safe bound: 95 % of a normal distribution lie within."""
_STARTUP_ERRORS: Final = 0.7
"""Standard errors at startup, when speed matters more than certainty. Ours."""
_STARTUP_ERRORS_PER_TRAIN: Final = 0.1
"""Each train of the startup adds this to them, up to `_ERRORS`. Ours."""
_LIKELY_ERRORS: Final = 1.5
"""Standard errors above the mean to which the rate may be raised step by step. Ours."""
_LIKELY_MIN_TRAINS: Final = 16
"""Minimum trains for a likely rate. Ours."""
_PRIOR_TRAINS: Final = 3
"""Weight, in trains, of the single packets' jitter as a prior of the trains' variance. Ours."""
_COMPRESSED_SHARE: Final = 0.9
"""A train that arrives in less than this share of its sending time was held and released at once
(TCP: ACK compression); that is no dispersion. Ours."""
_COMPRESSED_NOISES: Final = 2.0
"""Multiple of the delay noise by which it may be shorter still, because of jitter. Ours."""


class TrainDispersion(NamedTuple):
    """One train: its bits after the first packet, and the times from first to last packet."""

    judged_s: float
    bits: float
    sent_in_s: float
    came_in_s: float


class _Sums(NamedTuple):
    """Sums over all trains up to and including one; bits in thousands, times in ms."""

    judged_s: float
    bits: float
    ms: float
    bits_2: float
    bits_ms: float
    ms_2: float


_NONE: Final = _Sums(-math.inf, 0.0, 0.0, 0.0, 0.0, 0.0)


class DispersionEstimator:
    """Estimates from trains paced faster than the estimated rate; every query is cheap."""

    def __init__(self) -> None:
        self._sums: deque[_Sums] = deque([_NONE])

    def add(self, train: TrainDispersion, noise_s: float) -> None:
        """Count a train, unless it was compressed on the way."""
        while len(self) and self._sums[1].judged_s < train.judged_s - _MEMORY_S:
            self._sums.popleft()
        shortest_s = _COMPRESSED_SHARE * train.sent_in_s - _COMPRESSED_NOISES * noise_s
        if train.came_in_s < shortest_s:
            return
        if len(self) >= _MAX_TRAINS:
            self._sums.popleft()
        last = self._sums[-1]
        bits = train.bits / 1000
        ms = max(train.came_in_s, train.sent_in_s) * 1000
        self._sums.append(
            _Sums(
                train.judged_s,
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

    def min_bps(self, noise_s: float, *, startup: bool) -> float:
        """Return a lower bound of the rate: the best that the last 1, 2, 4… trains show."""
        errors = _ERRORS
        if startup:
            errors = min(_STARTUP_ERRORS + _STARTUP_ERRORS_PER_TRAIN * len(self), _ERRORS)
        min_bps, count = 0.0, 1
        while len(self) and count < 2 * len(self):
            min_bps = max(min_bps, self._bound_bps(min(count, len(self)), noise_s, errors))
            count *= 2
        return min_bps

    def likely_bps(self, noise_s: float) -> float:
        """Return the rate that the link probably carries; 0 if there are too few trains."""
        if len(self) < _LIKELY_MIN_TRAINS:
            return 0.0
        return self._bound_bps(len(self), noise_s, -_LIKELY_ERRORS)

    def _bound_bps(self, count: int, noise_s: float, errors: float) -> float:
        """Return the rate of the last `count` trains, less `errors` standard errors."""
        last, first = self._sums[-1], self._sums[-1 - count]
        bits, ms = last.bits - first.bits, last.ms - first.ms
        ms_per_bit = ms / bits
        # Few trains show little of their variance, so the single packets' variance counts too.
        squares = _PRIOR_TRAINS * 2 * (noise_s * 1000) ** 2
        squares += max(
            0.0,
            (last.ms_2 - first.ms_2)
            - 2 * ms_per_bit * (last.bits_ms - first.bits_ms)
            + ms_per_bit**2 * (last.bits_2 - first.bits_2),
        )
        ms += errors * math.sqrt(squares / (count + _PRIOR_TRAINS - 1)) * math.sqrt(count)
        return bits / ms * 1e6 if ms > 0 else math.inf
