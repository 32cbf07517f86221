"""Packet-train dispersion: what trains that left faster than the rate say about the bottleneck.

A train that is sent faster than the bottleneck serves comes out spread at its rate (Keshav's packet
pair, SIGCOMM 1991; trains: Dovrolis, Ramanathan, Moore, INFOCOM 2001). With cross traffic that is
their asymptotic dispersion rate, between available bandwidth and capacity. One train says little
through jitter, so the times of several are summed over the sum of their bits, with a confidence
interval of so many standard errors.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final, NamedTuple

_MEMORY_S: Final = 10.0
"""Trains of the last while count. BBR's bandwidth filter spans about as long (10 round trips).
Half: step-down: picture 174 ms → 144 ms; double: outages: use 35 % → 45 %."""

_MAX_TRAINS: Final = 128
"""More are not kept; at 30 pictures a second that is 4 s. Ours.
Half: step-down: picture 174 ms → 144 ms; double: the same."""

_ERRORS: Final = 2.0
"""Standard errors of a bound that is to be sure: 95 % of a normal distribution lie within.
Half: cellular: use 44 % → 49 %; double: route: use 89 % → 34 %."""

_STARTUP_ERRORS: Final = 0.7
"""Standard errors at startup, when to be soon matters more than to be sure. Ours.
Half: cellular: sound 127 ms → 79 ms; double: cellular: sound 127 ms → 79 ms."""

_STARTUP_ERRORS_PER_TRAIN: Final = 0.1
"""By so much each train of the startup makes the bound more careful, up to `_ERRORS`. Ours.
Half: wireless: concealed 0.5 % → 1.3 %; double: route: picture 137 ms → 273 ms."""

_LIKELY_ERRORS: Final = 1.5
"""Standard errors above the mean to which the rate may be raised step by step. Ours.
Half: outages: use 35 % → 44 %; double: outages: sound 41 ms → 51 ms."""

_LIKELY_MIN_TRAINS: Final = 16
"""Fewer trains say nothing of what is likely. Ours.
Half: route: picture 137 ms → 273 ms; double: route: picture 137 ms → 273 ms."""

_MAX_RATE_MIN_TRAINS: Final = 32
"""Fewer trains set no upper limit: cross traffic in one of them would. Ours.
Half: cellular: use 44 % → 49 %; double: step-down: picture 174 ms → 144 ms."""

_PRIOR_TRAINS: Final = 3
"""So many trains the jitter of single packets is worth as a prior of their variance. Ours.
Half: no change to speak of; double: step-down: picture 174 ms → 144 ms."""

_COMPRESSED_SHARE: Final = 0.9
"""A train that came in less of the time it was sent in was held and let go together: ACK
compression in TCP, no dispersion. Ours.
Half: no change to speak of; double: bursts: use 105 % → 68 %."""

_COMPRESSED_NOISES: Final = 2.0
"""So many times the delay noise it may be shorter still, for jitter does that too. Ours.
Half: no change to speak of; double: no change to speak of."""


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
    """Trains that were paced faster than the rate that was known; each question is cheap."""

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
        """Return what the link carries at least: the best that the last 1, 2, 4… trains show."""
        errors = _ERRORS
        if startup:
            errors = min(_STARTUP_ERRORS + _STARTUP_ERRORS_PER_TRAIN * len(self), _ERRORS)
        min_bps, count = 0.0, 1
        while len(self) and count < 2 * len(self):
            min_bps = max(min_bps, self._bound_bps(min(count, len(self)), noise_s, errors))
            count *= 2
        return min_bps

    def likely_bps(self, noise_s: float) -> float:
        """Return what the link may well carry; of few trains nothing."""
        if len(self) < _LIKELY_MIN_TRAINS:
            return 0.0
        return self._bound_bps(len(self), noise_s, -_LIKELY_ERRORS)

    def max_bps(self, noise_s: float) -> float:
        """Return what the link carries at most; only many trains limit it."""
        if len(self) < _MAX_RATE_MIN_TRAINS:
            return math.inf
        return self._bound_bps(len(self), noise_s, -_ERRORS)

    def _bound_bps(self, count: int, noise_s: float, errors: float) -> float:
        """Return the rate of the last `count` trains, so many standard errors below it."""
        last, first = self._sums[-1], self._sums[-1 - count]
        bits, ms = last.bits - first.bits, last.ms - first.ms
        ms_per_bit = ms / bits
        # A few trains say little about how much they differ, so what single packets say counts too.
        squares = _PRIOR_TRAINS * 2 * (noise_s * 1000) ** 2
        squares += max(
            0.0,
            (last.ms_2 - first.ms_2)
            - 2 * ms_per_bit * (last.bits_ms - first.bits_ms)
            + ms_per_bit**2 * (last.bits_2 - first.bits_2),
        )
        ms += errors * math.sqrt(squares / (count + _PRIOR_TRAINS - 1)) * math.sqrt(count)
        return bits / ms * 1e6 if ms > 0 else math.inf
