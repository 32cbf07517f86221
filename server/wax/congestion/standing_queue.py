"""Finds a standing queue, as in CoDel (RFC 8289): one that has not been empty for a while.

CoDel takes the minimum sojourn time of an interval, because a burst is no congestion; this takes
the minimum queuing delay of recent packets, end to end. CoDel's target of 5 ms needs a clock at the
queue itself; over a path with jitter the threshold adapts to it, as GCC's does (5.4).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from wax.congestion.queuing_delay import QueuingDelay

_TARGET_S: Final = 0.030
"""Smallest delay of a standing queue. CoDel: 5 ms in the queue itself; GCC begins at 12.5 ms;
NADA's QTH is 50 ms, SCReAM's lowest target 100 ms."""
_TARGET_PACKETS: Final = 1.5
"""On a thin link, it must also exceed the time of this many packets (CoDel: one MTU). Ours."""
_PACKET_BITS: Final = 8 * 250
"""A packet on a thin link, at the smallest payload that `packet_size` allows."""
_NOISE_FACTOR: Final = 3.0
"""And this multiple of the delay noise (99.7 % of a normal distribution)."""
_MAX_NOISE_S: Final = 0.060
"""Noise raises the threshold to at most this. GCC bounds its threshold by 600 ms. Ours."""
_MIN_SPAN_S: Final = 0.040
"""The packets must span this time: those that a stall released together show nothing. CoDel's
interval is 100 ms. Ours."""
_FEEDBACKS: Final = 2
"""Feedback packets in a row that must show it. GCC: overuse_time_th, 10 ms. Ours."""
_CERTAIN_FACTOR: Final = 2.5
"""Beyond this multiple of the threshold one feedback packet is enough. Ours."""
_GONE_SHARE: Final = 0.6
"""The queue is gone below this share of the threshold: hysteresis. Ours."""
_LEVEL_S: Final = 0.020
"""A standing delay that changes by no more is level. Ours."""


class StandingQueue:
    """Found when seen twice, or once if it is long; over when it is nearly gone."""

    def __init__(self) -> None:
        self._seen = 0
        self.since_s: float | None = None
        """When the queue was found, None without one."""
        self._level_s = 0.0
        self._level_from_s = 0.0

    def update(self, delay: QueuingDelay, rate_bps: float, now_s: float) -> bool:
        """Judge after each feedback; return whether the queue stands."""
        limit_s = self.limit_s(delay, rate_bps)
        standing_s = delay.standing_s
        if abs(standing_s - self._level_s) > _LEVEL_S:
            self._level_s, self._level_from_s = standing_s, now_s
        if self.since_s is not None:
            if standing_s < _GONE_SHARE * limit_s:
                self.since_s = None
                self._seen = 0
        elif standing_s <= limit_s:
            self._seen = 0
        elif delay.span_s >= _MIN_SPAN_S:
            self._seen += 1
            if self._seen >= _FEEDBACKS or standing_s > _CERTAIN_FACTOR * limit_s:
                self.since_s = now_s
        return self.since_s is not None

    def level_for_s(self, now_s: float) -> float:
        """Return how long the delay has been level; a queue's delay grows or shrinks."""
        return now_s - self._level_from_s

    def limit_s(self, delay: QueuingDelay, rate_bps: float) -> float:
        """Return the threshold, which allows for jitter and for a packet queued behind another."""
        noise_s = min(_NOISE_FACTOR * delay.noise_s, _MAX_NOISE_S)
        return max(_TARGET_S, _TARGET_PACKETS * _PACKET_BITS / rate_bps, noise_s)

    def clear(self) -> None:
        self._seen = 0
        self.since_s = None
