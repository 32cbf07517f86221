"""The pacer: a leaky bucket that makes pictures wait until the link has drained.

Sound is counted but never waits, so pictures give way. It counts bits, so that the debt takes
longer to drain when the rate falls.
"""

from __future__ import annotations

import math
from typing import Final

_MAX_DEBT_S: Final = 10.0
"""Maximum debt: after that long, every packet has arrived or is lost."""


def gap_s(size_bytes: int, pace_bps: float) -> float:
    """Return the gap between a datagram of `size_bytes` and the next one of its train."""
    return size_bytes * 8 / pace_bps


class Pacer:
    """Knows when the link is free again; a `now_s` that falls frees nothing."""

    def __init__(self, rate_bps: float) -> None:
        self.rate_bps = rate_bps
        """How fast the queue empties."""
        self._owed_bits = 0.0
        self._measured_bits = 0.0
        self._now_s = -math.inf

    def spend(self, size_bytes: int, now_s: float) -> None:
        """Count one datagram, headers included."""
        self._pass(now_s)
        most_bits = _MAX_DEBT_S * self.rate_bps
        self._owed_bits = min(self._owed_bits + size_bytes * 8, most_bits)
        self._measured_bits = min(self._measured_bits + size_bytes * 8, most_bits)

    def drain(self, queue_ms: float, now_s: float) -> None:
        """Replace the measured queue of the link, 0 to 10 s.

        The larger of debt and measured queue counts: the same datagrams are in both.
        """
        self._pass(now_s)
        self._measured_bits = queue_ms / 1000 * self.rate_bps

    def forgive(self) -> None:
        """Forget a debt that no queue confirms: the rate was wrong."""
        self._owed_bits = min(self._owed_bits, self._measured_bits)

    def free_in_s(self, now_s: float) -> float:
        """Return how long a picture still has to wait; 0 if it may leave."""
        self._pass(now_s)
        return max(self._owed_bits, self._measured_bits) / self.rate_bps

    def _pass(self, now_s: float) -> None:
        if now_s > self._now_s:
            paid_bits = (now_s - self._now_s) * self.rate_bps
            self._owed_bits = max(0.0, self._owed_bits - paid_bits)
            self._measured_bits = max(0.0, self._measured_bits - paid_bits)
            self._now_s = now_s
