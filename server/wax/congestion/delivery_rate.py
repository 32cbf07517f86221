"""The rate of the bottleneck, measured from its queue and from packet trains.

Delivery rate of a busy link (draft-cheng-iccrg-delivery-rate-estimation): a queue that never
empties drains at the link's capacity, not limited by the application.

Packet-train dispersion: the bottleneck spreads a train sent faster than its own rate (Keshav's
packet pair, SIGCOMM 1991; trains: Dovrolis, Ramanathan, Moore, INFOCOM 2001). With cross traffic
the result is the asymptotic dispersion rate, between available bandwidth and capacity. Jitter hides
most of one train's dispersion, so the times and bits of several are summed, with a confidence
interval.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from itertools import pairwise
from operator import add, sub
from typing import TYPE_CHECKING, Final, NamedTuple

from wax.bounded_dict import BoundedDict

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

_WINDOW_S: Final = 0.8
"""Measured over at most this much of a busy period. GCC: 0.5 to 1 s (T in 5.6)."""
_MIN_BUSY_S: Final = 0.06
"""Minimum busy period: the arrivals within one feedback packet have jitter."""
_MAX_PACKETS: Final = 512
"""At most this many packets are kept: the window at 640 a second. It bounds the work if a page's
clock stops."""
_BACK_TO_BACK_S: Final = 0.005
"""Two packets count as queued if the first arrives more than this after the second would have
arrived without a queue. As GCC's burst_time (5.6)."""
_MEMORY_S: Final = 10.0
"""Trains older than this do not count. BBR's bandwidth filter is about as long (10 round trips)."""
_ERRORS: Final = 2.0
"""Standard errors of a safe bound: 95 % of a normal distribution lie within."""
_STARTUP_ERRORS: Final = 0.7
"""Standard errors at startup, when speed matters more than certainty."""
_LIKELY_ERRORS: Final = 1.5
"""Standard errors above the mean up to which the rate may be raised step by step."""
_LIKELY_MIN_TRAINS: Final = 16
"""Minimum trains for a likely rate."""
_PRIOR_TRAINS: Final = 3
"""Weight, in trains, of the packet jitter as a prior: few trains show little of their variance."""
_MAX_TRAINS: Final = 64
"""At most this many trains are in flight: 2 s of pictures. It bounds memory."""
_MAX_DISPERSION_S: Final = 30.0
"""A train with a longer dispersion is ignored as invalid."""


class Arrival(NamedTuple):
    """A packet that arrived; `until_bytes` counts all bytes up to it. The two clocks differ."""

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
    """Fed with every packet that arrived, in the order of sending; times in seconds."""

    def __init__(self) -> None:
        self._busy: deque[Arrival] = deque(maxlen=_MAX_PACKETS)

    def add(self, arrival: Arrival, base_s: float) -> None:
        """Count a packet; `base_s` is how long it would have taken without a queue."""
        unqueued_s = arrival.sent_s + base_s + _BACK_TO_BACK_S
        if self._busy and not unqueued_s < self._busy[-1].arrived_s <= arrival.arrived_s:
            self._busy.clear()
        self._busy.append(arrival)
        while len(self._busy) > 2 and self._busy[1].arrived_s < arrival.arrived_s - _WINDOW_S:
            self._busy.popleft()

    def rate_bps(self) -> float | None:
        """Return the rate of the current busy period; None if it is too short."""
        return steady_bps(self._busy, _MIN_BUSY_S)


@dataclass(slots=True)
class _Train:
    unreported: int
    arrivals: list[Arrival] = field(default_factory=list)


class PacketTrains:
    """The trains in flight that were sent faster than the estimated rate, a bounded number."""

    def __init__(self) -> None:
        self._trains = BoundedDict[int, _Train](_MAX_TRAINS)

    def register(self, number: int, packets: int) -> None:
        """Register a train before it is sent; numbers rise."""
        self._trains[number] = _Train(packets)

    def add(self, number: int, arrival: Arrival | None) -> Iterator[list[Arrival]]:
        """Count a packet of a train, in the order of sending; a lost one is None.

        Yield the arrivals of each train that it completes: its own after the last packet, and all
        earlier trains. The caller may call `clear` between two yields.
        """
        while (first := next(iter(self._trains), number)) < number:
            yield self._trains.pop(first).arrivals
        train = self._trains.get(number)
        if train is None:
            return
        if arrival is not None:
            train.arrivals.append(arrival)
        train.unreported -= 1
        if train.unreported <= 0:
            yield self._trains.pop(number).arrivals

    def clear(self) -> None:
        self._trains.clear()


class DispersionEstimator:
    """Estimates from trains paced faster than the estimated rate; every query is cheap."""

    def __init__(self) -> None:
        # When each train was added, and the running sums of bits, ms, bits², bits·ms and ms²; bits
        # in thousands.
        self._sums: deque[tuple[float, Sequence[float]]] = deque([(-math.inf, (0.0,) * 5)])

    def __len__(self) -> int:
        return len(self._sums) - 1

    def add(self, arrivals: Sequence[Arrival], now_s: float) -> float | None:
        """Count a train; return by how much the link spread it, in s, None if it is unusable."""
        if len(arrivals) < 2:
            return None
        first, last = arrivals[0], arrivals[-1]
        came_in_s = last.arrived_s - first.arrived_s
        if not 0 <= came_in_s < _MAX_DISPERSION_S:
            return None
        while len(self) and self._sums[1][0] < now_s - _MEMORY_S:
            self._sums.popleft()
        sent_in_s = max(last.sent_s - first.sent_s, 1e-6)
        bits = 8 * (last.until_bytes - first.until_bytes) / 1000
        # A train that was held and released at once shows no more than its sending pace.
        ms = max(came_in_s, sent_in_s) * 1000
        more = (bits, ms, bits * bits, bits * ms, ms * ms)
        self._sums.append((now_s, tuple(map(add, self._sums[-1][1], more))))
        return came_in_s - sent_in_s

    def min_bps(self, noise_s: float, *, startup: bool) -> float:
        """Return a lower bound of the rate: the highest bound of the last 1, 2, 4… trains."""
        errors = _STARTUP_ERRORS if startup else _ERRORS
        min_bps, count = 0.0, 1
        while count < 2 * len(self):
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
        bits, ms, bits_2, bits_ms, ms_2 = map(sub, self._sums[-1][1], self._sums[-1 - count][1])
        ms_per_bit = ms / bits
        squares = _PRIOR_TRAINS * 2 * (noise_s * 1000) ** 2
        squares += max(0.0, ms_2 - 2 * ms_per_bit * bits_ms + ms_per_bit**2 * bits_2)
        ms += errors * math.sqrt(squares / (count + _PRIOR_TRAINS - 1)) * math.sqrt(count)
        return bits / ms * 1e6 if ms > 0 else math.inf
