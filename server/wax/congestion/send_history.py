"""Counts the bytes sent to one browser between any two recent moments."""

from __future__ import annotations

import math
from array import array
from bisect import bisect_right
from operator import sub
from typing import Final

_KEPT_PACKETS: Final = 2048
"""At least this many datagrams are kept: 4 s at the 500 a second of the largest rendition. It
bounds memory; `between` and `queue_s` look back 2 s and one round trip."""
_USED_S: Final = 1.0
"""The rate in use is averaged over this time. GCC's T is 0.5 to 1 s."""


class SendHistory:
    """Times never fall from one `add` to the next."""

    def __init__(self) -> None:
        # Arrays take 16 bytes a datagram, lists of numbers four times that.
        # The first entry sums up everything sent before the kept datagrams.
        self._times_s = array("d", [-math.inf])
        self._sums = array("Q", [0])

    def add(self, size_bytes: int, now_s: float) -> None:
        if len(self._times_s) > 2 * _KEPT_PACKETS:
            del self._times_s[:_KEPT_PACKETS], self._sums[:_KEPT_PACKETS]
            self._times_s[0] = -math.inf
        self._times_s.append(now_s)
        self._sums.append(self._sums[-1] + size_bytes)

    def between(self, after_s: float, until_s: float) -> int:
        """Return the bytes that left later than `after_s` and not later than `until_s`."""
        return max(0, self._until(until_s) - self._until(after_s))

    def used_bps(self, now_s: float) -> float:
        """Return the rate over the last second."""
        return 8.0 * self.between(now_s - _USED_S, now_s) / _USED_S

    def queue_s(self, queued_s: float, sent_s: float, now_s: float, rate_bps: float) -> float:
        """Return the present queue of a link of `rate_bps`, in seconds.

        It was `queued_s` when the packet sent at `sent_s` joined it; later packets are added.
        """
        first, most = bisect_right(self._times_s, sent_s), self._sums[-1]
        took_s = 8 / rate_bps
        queued_s += (most - self._sums[first - 1]) * took_s - (now_s - sent_s)
        if first < len(self._times_s):
            # Lindley's recursion in closed form: the last packet to find no queue began the present
            # one. It all runs in C, since a silent page leaves thousands of packets unreported.
            starts_s = map(took_s.__mul__, self._sums[first - 1 : -1])
            began_s = max(map(sub, self._times_s[first:], starts_s))
            queued_s = max(queued_s, most * took_s - (now_s - began_s))
        return max(0.0, queued_s)

    def _until(self, time_s: float) -> int:
        return self._sums[bisect_right(self._times_s, time_s) - 1]
