"""The delivery rate of a busy link: a queue that never empties drains at the link's capacity.

The delivery rate sample of draft-cheng-iccrg-delivery-rate-estimation, taken over busy periods
only, so that the application never limits it.
"""

from __future__ import annotations

from collections import deque
from itertools import pairwise
from typing import TYPE_CHECKING, Final, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterable

_WINDOW_S: Final = 0.8
"""Measured over at most this much of a busy period. GCC: 0.5 to 1 s (T in 5.6)."""
_MIN_BUSY_S: Final = 0.06
"""Minimum busy period: the arrivals within one feedback packet have jitter."""
_MAX_PACKETS: Final = 512
"""Packets kept at most: the window at 640 a second. Bounds the work where a page's clock stands."""
_BACK_TO_BACK_S: Final = 0.005
"""How much later than this packet would have come alone the one before must arrive, for both to
count as queued. As GCC's burst_time (5.6)."""


class Arrival(NamedTuple):
    """A packet that arrived as the last of `until_bytes`; times of two clocks."""

    sent_s: float
    arrived_s: float
    until_bytes: int


def steady_bps(arrivals: Iterable[Arrival], least_s: float = 0.0) -> float | None:
    """Return the rate without the longest gap: a stall pauses a link but does not change its rate.

    None if the other gaps together take no longer than `least_s`.
    """
    gaps = [
        (later.arrived_s - one.arrived_s, later.until_bytes - one.until_bytes)
        for one, later in pairwise(arrivals)
    ]
    longest = max(gaps, default=(0.0, 0))
    took_s = sum(gap_s for gap_s, _ in gaps) - longest[0]
    size_bytes = sum(size for _, size in gaps) - longest[1]
    return size_bytes * 8 / took_s if took_s > least_s else None


class DeliveryRate:
    """Takes every packet that arrived, in the order of sending; times in seconds."""

    def __init__(self) -> None:
        self._busy: deque[Arrival] = deque(maxlen=_MAX_PACKETS)

    def add(self, arrival: Arrival, base_s: float) -> None:
        """Count a packet; `base_s` is how long it would have taken without a queue.

        If the packet before arrived no earlier than that, both left the queue back to back.
        """
        unqueued_s = arrival.sent_s + base_s + _BACK_TO_BACK_S
        if self._busy and not unqueued_s < self._busy[-1].arrived_s <= arrival.arrived_s:
            self._busy.clear()
        self._busy.append(arrival)
        while len(self._busy) > 2 and self._busy[1].arrived_s < arrival.arrived_s - _WINDOW_S:
            self._busy.popleft()

    def rate_bps(self) -> float | None:
        """Return the rate of the current busy period; None if it is too short."""
        return steady_bps(self._busy, _MIN_BUSY_S)

    def clear(self) -> None:
        self._busy.clear()
