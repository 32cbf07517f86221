"""Queuing delay from one-way delays between two unsynchronised clocks.

As in LEDBAT (RFC 6817), NADA and SCReAM: arrival minus sending time includes the clocks' unknown
offset; the excess over the base delay, the minimum of the last half minute, is queuing. Clock drift
(100 ppm: 3 ms in that time) and old routes expire with it.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final

_BASE_MEMORY_S: Final = 30.0
"""How long a base delay counts. LEDBAT: up to 10 minutes; BBR's min_rtt: 10 s. A drift of 100 ppm
makes it 3 ms wrong; a queue that stands longer would count as the path."""
_BASE_BUCKET_S: Final = 0.5
"""One base delay is kept for each interval of this length: it bounds memory. LEDBAT: a minute."""
_RECENT_S: Final = 0.07
"""The standing delay is the minimum over this time. CoDel's interval is 100 ms. Ours: less than two
feedback intervals, so that a queue is found within 200 ms."""
_RECENT_PACKETS: Final = 3
"""And over at least this many packets. Ours."""
_MAX_RECENT_PACKETS: Final = 256
"""And over at most this many: 3600 a second. Bounds the work where a page's clock stands."""
_SMALL_PACKET_BYTES: Final = 100
"""Bytes beyond this take extra time to send, which is not queuing; a packet of sound has none."""
_NOISE_GAIN: Final = 0.1
"""Weight of a new difference in the mean square. RFC 3550's jitter (6.4.1): 1/16. Ours."""
_FIRST_NOISE_S: Final = 0.002
"""Noise before any packet. Ours."""
_NOISE_MAX_FACTOR: Final = 3.0
"""A difference counts as at most this multiple of the noise, so that one stall does not make the
path look noisy for long. GCC clips at 3 sigma, too (5.3)."""
_NOISE_MAX_STEP_S: Final = 0.001
"""Plus this, so that the noise can grow from zero. Ours."""


class QueuingDelay:
    """Takes every packet that arrived, in the order of sending; times in seconds."""

    def __init__(self) -> None:
        self._base: deque[tuple[float, float]] = deque()  # rising, from buckets of time
        self._recent: deque[tuple[float, float]] = deque(maxlen=_MAX_RECENT_PACKETS)
        self._before_s: float | None = None
        self._noise_squared = _FIRST_NOISE_S**2

    @property
    def base_s(self) -> float:
        """The minimum one-way delay, including the clocks' offset; infinite before any packet."""
        return self._base[0][1] if self._base else math.inf

    @property
    def noise_s(self) -> float:
        """The root mean square of the delay's difference from one packet to the next."""
        return math.sqrt(self._noise_squared)

    @property
    def standing_s(self) -> float:
        """The minimum queuing delay of recent packets.

        The minimum, because one late packet is no queue, and the last of the packets that a stall
        held and released together was not queued.
        """
        return min((queued_s for _, queued_s in self._recent), default=0.0)

    @property
    def span_s(self) -> float:
        """The time over which the packets of `standing_s` arrived."""
        return self._recent[-1][0] - self._recent[0][0] if self._recent else 0.0

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

    def relearn(self) -> None:
        """Forget the base delay: the route has become longer."""
        self._base.clear()
        self._recent.clear()
        self._before_s = None

    def _follow(self, sent_s: float, delay_s: float) -> None:
        while self._base and self._base[0][0] < sent_s - _BASE_MEMORY_S:
            self._base.popleft()
        if (
            self._base
            and delay_s >= self._base[-1][1]
            and sent_s < self._base[-1][0] + _BASE_BUCKET_S
        ):
            return
        while self._base and self._base[-1][1] >= delay_s:
            self._base.pop()
        self._base.append((sent_s, delay_s))
