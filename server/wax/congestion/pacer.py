"""The pacer: a leaky bucket that pictures wait for, until what was sent has left the link.

Sound spends without asking, so a picture is what gives way. Counted in bits, so that what is
owed takes longer when the rate falls.
"""

from __future__ import annotations

import math
from typing import Final

_MIN_RATE_BPS: Final = 1_000.0
"""A bound against division by nothing: the estimator never goes below 8 kbit/s."""

_MAX_DEBT_S: Final = 10.0
"""More is never owed: after that long everything that was sent has arrived or is lost.
Half: the same; double: the same."""


def gap_s(size_bytes: int, pace_bps: float) -> float:
    """Return how long after a datagram of `size_bytes` the next of its train shall leave."""
    return size_bytes * 8 / max(pace_bps, _MIN_RATE_BPS)


class Pacer:
    """Tells when the link is free again. A `now_s` that falls frees nothing."""

    def __init__(self, rate_bps: float) -> None:
        self._rate_bps = max(rate_bps, _MIN_RATE_BPS)
        self._owed_bits = 0.0
        self._measured_bits = 0.0
        self._now_s = -math.inf

    @property
    def rate_bps(self) -> float:
        """How fast the queue empties; at least 1 kbit/s."""
        return self._rate_bps

    @rate_bps.setter
    def rate_bps(self, rate_bps: float) -> None:
        if math.isfinite(rate_bps):
            self._rate_bps = max(rate_bps, _MIN_RATE_BPS)

    def spend(self, size_bytes: int, now_s: float) -> None:
        """Count one datagram, headers and all."""
        self._pass(now_s)
        most_bits = _MAX_DEBT_S * self._rate_bps
        bits = max(size_bytes, 0) * 8
        self._owed_bits = min(self._owed_bits + bits, most_bits)
        self._measured_bits = min(self._measured_bits + bits, most_bits)

    def drain(self, queue_ms: float, now_s: float) -> None:
        """Count what is measured to wait in the link, instead of what was measured before.

        It counts as far as it is more than what is owed: the same datagrams are in both.
        """
        self._pass(now_s)
        if math.isfinite(queue_ms):
            waiting_s = min(max(queue_ms / 1000, 0.0), _MAX_DEBT_S)
            self._measured_bits = waiting_s * self._rate_bps

    def free_in_s(self, now_s: float) -> float:
        """Return how long a picture has yet to wait, 0 when it may go."""
        self._pass(now_s)
        return max(self._owed_bits, self._measured_bits) / self._rate_bps

    def _pass(self, now_s: float) -> None:
        if not now_s > self._now_s or not math.isfinite(now_s):
            return
        if self._now_s > -math.inf:
            paid_bits = (now_s - self._now_s) * self._rate_bps
            self._owed_bits = max(0.0, self._owed_bits - paid_bits)
            self._measured_bits = max(0.0, self._measured_bits - paid_bits)
        self._now_s = now_s
