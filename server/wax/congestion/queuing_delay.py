"""Queuing delay and jitter from one-way delays between unsynchronised clocks; standing queues.

As in LEDBAT (RFC 6817), NADA (RFC 8698) and SCReAM (RFC 8298): arrival minus sending time includes
the clocks' unknown offset; the excess over the base delay, the minimum of the last half minute, is
queuing. Clock drift (100 ppm: 3 ms in that time) and old routes expire with it.

A *standing* queue has not been empty for a while. CoDel (RFC 8289) takes the minimum sojourn time
of an interval, because a burst is no congestion; this takes the minimum queuing delay of recent
packets, end to end, above a threshold that adapts to the path's jitter, as GCC's does (5.4).
"""

from __future__ import annotations

import math
from bisect import bisect_left, insort
from collections import deque
from typing import Final

_BASE_MEMORY_S: Final = 30.0
"""How long a base delay counts; a queue that lasts longer is missed. LEDBAT: 10 min, BBR: 10 s."""
_BASE_BUCKET_S: Final = 0.5
"""One base delay is kept for each interval of this length: it bounds memory. LEDBAT: a minute."""
_RECENT_S: Final = 0.07
"""The standing delay is the minimum over this time. CoDel's interval is 100 ms. Ours: less than two
feedback intervals, so that a queue is found within 200 ms."""
_RECENT_PACKETS: Final = 3
"""And over at least this many packets: a link whose rate falls takes long for each."""
_MAX_RECENT_PACKETS: Final = 256
"""And over at most this many: 3600 a second. It bounds the work if a page's clock stops."""
_SMALL_PACKET_BYTES: Final = 100
"""Bytes beyond this take serialization time, which is not queuing; sound packets are smaller."""
_NOISE_GAIN: Final = 0.1
"""Weight of a new difference in the mean square. RFC 3550's jitter (6.4.1): 1/16."""
_FIRST_NOISE_S: Final = 0.002
"""Assumed noise before the first packet."""
_NOISE_MAX_FACTOR: Final = 3.0
"""A difference counts as at most this multiple of the noise, so that one stall does not make the
path look noisy for long. GCC clips at 3 sigma, too (5.3)."""
_NOISE_MAX_STEP_S: Final = 0.001
"""Plus this, so that the noise can grow from zero."""
_TARGET_S: Final = 0.030
"""Smallest delay of a standing queue. CoDel: 5 ms in the queue itself; GCC begins at 12.5 ms;
NADA's QTH is 50 ms, SCReAM's lowest target 100 ms."""
_TARGET_PACKETS: Final = 1.5
"""On a thin link it must also exceed the serialization time of this many packets (CoDel: one
MTU)."""
PACKET_BITS: Final = 8 * 250
"""A packet on a thin link, at the smallest payload that `wire_cost` allows."""
_NOISE_FACTOR: Final = 3.0
"""And this multiple of the delay noise (99.7 % of a normal distribution)."""
_MAX_NOISE_S: Final = 0.060
"""Noise raises the threshold to at most this. GCC bounds its threshold by 600 ms."""
_MIN_SPAN_S: Final = 0.040
"""The packets must span this time: packets that a stall released together prove nothing."""
_FEEDBACKS: Final = 2
"""Consecutive feedback packets that must show the queue. GCC: overuse_time_th, 10 ms."""
_LEVEL_S: Final = 0.020
"""A standing delay that changes by no more than this is level."""
_JITTER_MEMORY_S: Final = 8.0
"""How long a delay counts, as in the page's built-in player: 400 packets at 50 a second."""
_MAX_JITTER_PACKETS: Final = 4000
"""At most this many packets are kept; 8 s of sound are 800. It bounds memory."""
_QUANTILE: Final = 0.99
"""Share of the sound that must arrive in time. Ours; NetEq follows 95 to 97 %."""
MAX_MS: Final = 10_000.0
"""Longest jitter and queue, against invalid feedback."""


class QueuingDelay:
    """Fed with every packet that arrived, in the order of sending; times in seconds."""

    def __init__(self) -> None:
        self._base: deque[tuple[float, float]] = deque()  # rising delays, one per time bucket
        self._recent: deque[tuple[float, float]] = deque(maxlen=_MAX_RECENT_PACKETS)
        self._before_s: float | None = None
        self._noise_squared = _FIRST_NOISE_S**2
        self._seen = 0
        self._level_s = 0.0
        self.level_from_s = 0.0
        """Since when the delay has been level."""

    @property
    def stands(self) -> bool:
        return self._seen >= _FEEDBACKS

    @property
    def base_s(self) -> float:
        """The minimum one-way delay, including the clocks' offset; infinite before any packet."""
        return self._base[0][1] if self._base else math.inf

    @property
    def noise_s(self) -> float:
        """The root mean square of the delay's difference from one packet to the next."""
        return math.sqrt(self._noise_squared)

    def add(self, sent_s: float, arrived_s: float, size_bytes: int, rate_bps: float) -> float:
        """Count a packet; return its delay above the base delay."""
        delay_s = arrived_s - sent_s
        self._follow(sent_s, delay_s)
        if self._before_s is not None:
            most_s = _NOISE_MAX_FACTOR * self.noise_s + _NOISE_MAX_STEP_S
            step_s = min(abs(delay_s - self._before_s), most_s)
            self._noise_squared += _NOISE_GAIN * (step_s * step_s - self._noise_squared)
        self._before_s = delay_s
        own_s = max(0, size_bytes - _SMALL_PACKET_BYTES) * 8 / rate_bps
        queued_s = max(0.0, delay_s - self.base_s - own_s)
        self._recent.append((arrived_s, queued_s))
        while len(self._recent) > _RECENT_PACKETS and (
            self._recent[0][0] < arrived_s - _RECENT_S or self._recent[0][0] > arrived_s
        ):
            self._recent.popleft()
        return max(0.0, delay_s - self.base_s)

    def judge(self, rate_bps: float, now_s: float) -> None:
        """Decide whether there is a standing queue; call it after each feedback packet."""
        # One late packet is no queue, and the last packet that a stall held was not queued.
        standing_s = min((queued_s for _, queued_s in self._recent), default=0.0)
        if abs(standing_s - self._level_s) > _LEVEL_S:
            self._level_s, self.level_from_s = standing_s, now_s
        if standing_s <= self.limit_s(rate_bps):
            self._seen = 0
        elif self._recent[-1][0] - self._recent[0][0] >= _MIN_SPAN_S:
            self._seen += 1

    def limit_s(self, rate_bps: float) -> float:
        """Return the threshold, which allows for jitter and one packet queued behind another."""
        packets_s = _TARGET_PACKETS * PACKET_BITS / rate_bps
        noise_s = min(_NOISE_FACTOR * self.noise_s, _MAX_NOISE_S)
        return max(_TARGET_S, packets_s, noise_s)

    def relearn(self) -> None:
        """Forget the base delay: the route has become longer."""
        self._base.clear()
        self._recent.clear()
        self._before_s = None
        self._seen = 0

    def _follow(self, sent_s: float, delay_s: float) -> None:
        while self._base and self._base[0][0] < sent_s - _BASE_MEMORY_S:
            self._base.popleft()
        if self._base:
            began_s, least_s = self._base[-1]
            if delay_s >= least_s and sent_s < began_s + _BASE_BUCKET_S:
                return
        while self._base and self._base[-1][1] >= delay_s:
            self._base.pop()
        self._base.append((sent_s, delay_s))


class Jitter:
    """Packet delay variation of the sound (RFC 5481, 4.2); `now_s` never falls."""

    def __init__(self) -> None:
        self._delays: deque[tuple[float, float]] = deque()  # time reported, delay
        self._ordered: list[float] = []

    @property
    def ms(self) -> float:
        """The 99th percentile of the delays, in ms above the shortest one."""
        if not self._ordered:
            return 0.0
        at = int(_QUANTILE * (len(self._ordered) - 1) + 0.5)
        return min((self._ordered[at] - self._ordered[0]) * 1000, MAX_MS)

    def add(self, delay_s: float, now_s: float) -> None:
        """Count a packet that took `delay_s` between two clocks whose offset is unknown."""
        self._delays.append((now_s, delay_s))
        insort(self._ordered, delay_s)
        while (
            self._delays[0][0] < now_s - _JITTER_MEMORY_S or len(self._delays) > _MAX_JITTER_PACKETS
        ):
            del self._ordered[bisect_left(self._ordered, self._delays.popleft()[1])]

    def forget_since(self, from_s: float, above_s: float) -> None:
        """Drop the delays reported since `from_s` that are longer than `above_s`."""
        # The answer to a queue is to send less, not a longer buffer.
        self._delays = deque(one for one in self._delays if one[0] < from_s or one[1] <= above_s)
        self._ordered = sorted(delay_s for _, delay_s in self._delays)
