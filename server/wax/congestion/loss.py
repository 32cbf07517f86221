"""Loss-based control beside the delay-based one (GCC, section 6), and the length of loss bursts.

Loss alone lowers the rate only if it is much higher than usual: a radio link that always loses
5 % is not congested. GCC's bounds are fixed (2 and 10 %); ours learn the usual loss.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final, NamedTuple

_BUCKET_S: Final = 0.25
"""Packets are counted in intervals of this length. Ours."""
_MEMORY_S: Final = 10.0
"""Loss is averaged over this time; RTCP reports cover about 5 s (RFC 3550, 6.2). Ours."""
_HIGH_LOSS_SHARE: Final = 0.12
"""Loss beyond the usual that lowers the rate. GCC: 10 %."""
_USUAL_FACTOR: Final = 2.0
"""The usual loss times this, plus `_HIGH_LOSS_SHARE`, is high loss. Ours."""
_HIGH_LOSS_S: Final = 2.0
"""High loss is judged over this time, and the rate stays for as long after a fall. Ours."""
_SEVERE_LOSS_SHARE: Final = 0.4
"""Loss that lowers the rate at once, however high the usual loss is. Ours."""
_SEVERE_LOSS_S: Final = 1.0
"""Severe loss is judged over this time. Ours."""
_MIN_PACKETS: Final = 40
"""Minimum packets to judge by: the standard error of 12 % of 40 is 5 %. Ours."""
_DECREASE_FACTOR: Final = 0.9
"""Share of the arriving rate that is used after a fall, so that the queue drains. GCC's beta is
0.85."""
_MAX_DECREASE_FACTOR: Final = 0.5
"""A fall leaves at least this share of the rate, as GCC's 1 - 0.5 p does if everything is lost."""
_USUAL_GAIN: Final = _BUCKET_S / 20
"""The usual loss is an average over about 20 s. Ours."""
_USUAL_MIN_BUCKETS: Final = 8
"""The average starts as if this many buckets without loss came before. Ours."""
_BURSTS: Final = 200
"""Loss bursts kept at most. Bounds the memory."""
_BURSTS_S: Final = 30.0
"""How long they are kept. Ours."""
_BURST_QUANTILE: Final = 0.95
"""Share of the bursts that redundancy must repair (RFC 2198). Ours."""


class _LossCounts(NamedTuple):
    """The packets reported over some time."""

    packets: int
    lost: int
    arrived_bytes: int

    @property
    def lost_share(self) -> float:
        return self.lost / self.packets if self.packets else 0.0


class _Bucket:
    __slots__ = ("arrived_bytes", "lost", "packets", "start_s")

    def __init__(self, start_s: float) -> None:
        self.start_s = start_s
        self.packets = self.lost = self.arrived_bytes = 0


class LossControl:
    """Takes every packet in the order of sending; `now_s` never falls."""

    def __init__(self) -> None:
        self._buckets: deque[_Bucket] = deque()
        self._packets = self._lost = 0  # of all buckets
        self._bursts = _Bursts()
        self._sound_bursts = _Bursts()
        self._usual_share = 0.0
        self._closed = 0
        self._congested = False
        self._judged_from_s = -math.inf

    @property
    def share(self) -> float:
        """The share of packets lost in the last 10 s."""
        return self._lost / self._packets if self._packets else 0.0

    @property
    def congested(self) -> bool:
        """Whether loss has lowered the rate, and nothing yet shows that it fell far enough."""
        return self._congested

    def add(self, size_bytes: int, *, lost: bool, sound: bool, now_s: float) -> None:
        if not self._buckets or now_s >= self._buckets[-1].start_s + _BUCKET_S:
            self._close(now_s)
            self._buckets.append(_Bucket(now_s))
        bucket = self._buckets[-1]
        bucket.packets += 1
        self._packets += 1
        if lost:
            bucket.lost += 1
            self._lost += 1
        else:
            bucket.arrived_bytes += size_bytes
        self._bursts.add(lost=lost, now_s=now_s)
        if sound:
            self._sound_bursts.add(lost=lost, now_s=now_s)

    def judge(self, rate_bps: float, *, queue_stands: bool, now_s: float) -> float | None:
        """Return the rate after a fall because of loss, None if it stays.

        High loss without a standing queue means that the link's queue is too short to measure. A
        standing queue loses packets too, but its delay is the better signal.
        """
        if queue_stands:
            self._congested, self._judged_from_s = False, now_s
            return None
        severe = self._since(max(now_s - _SEVERE_LOSS_S, self._judged_from_s))
        if severe.packets >= _MIN_PACKETS and severe.lost_share > _SEVERE_LOSS_SHARE:
            return self._fallen_bps(severe.arrived_bytes * 8 / _SEVERE_LOSS_S, rate_bps, now_s)
        if now_s - self._judged_from_s < _HIGH_LOSS_S:
            return None
        high = self._since(max(now_s - _HIGH_LOSS_S, self._judged_from_s))
        limit_share = _HIGH_LOSS_SHARE + _USUAL_FACTOR * self._usual_share
        self._congested = high.packets >= _MIN_PACKETS and high.lost_share > limit_share
        if not self._congested:
            return None
        return self._fallen_bps(high.arrived_bytes * 8 / _HIGH_LOSS_S, rate_bps, now_s)

    def burst(self) -> int:
        """Return the number of packets lost in a row (95th percentile), 0 without loss.

        It counts the sound alone if sound is sent: its packets are sparser, so its bursts shorter.
        """
        return (
            self._sound_bursts.longest() if self._sound_bursts.is_used else self._bursts.longest()
        )

    def forget(self, now_s: float) -> None:
        """Reset the counts, but keep the burst lengths."""
        self._buckets.clear()
        self._packets = self._lost = 0
        self._congested, self._judged_from_s = False, now_s

    def _fallen_bps(self, came_bps: float, rate_bps: float, now_s: float) -> float:
        self._congested, self._judged_from_s = True, now_s
        return max(_DECREASE_FACTOR * came_bps, _MAX_DECREASE_FACTOR * rate_bps)

    def _since(self, from_s: float) -> _LossCounts:
        packets = lost = arrived_bytes = 0
        for bucket in reversed(self._buckets):
            if bucket.start_s < from_s:
                break
            packets += bucket.packets
            lost += bucket.lost
            arrived_bytes += bucket.arrived_bytes
        return _LossCounts(packets, lost, arrived_bytes)

    def _close(self, now_s: float) -> None:
        if self._buckets:
            bucket = self._buckets[-1]
            self._closed += 1
            gain = max(_USUAL_GAIN, 1 / (_USUAL_MIN_BUCKETS + self._closed))
            self._usual_share += gain * (bucket.lost / bucket.packets - self._usual_share)
        while self._buckets and self._buckets[0].start_s < now_s - _MEMORY_S:
            old = self._buckets.popleft()
            self._packets -= old.packets
            self._lost -= old.lost


class _Bursts:
    """Lengths of bursts of lost packets."""

    def __init__(self) -> None:
        self._ended: deque[tuple[float, int]] = deque(maxlen=_BURSTS)
        self._length = 0
        self.is_used = False

    def add(self, *, lost: bool, now_s: float) -> None:
        self.is_used = True
        if lost:
            self._length += 1
        elif self._length:
            self._ended.append((now_s, self._length))
            self._length = 0
        while self._ended and self._ended[0][0] < now_s - _BURSTS_S:
            self._ended.popleft()

    def longest(self) -> int:
        lengths = sorted(length for _, length in self._ended)
        if not lengths:
            return self._length
        return lengths[min(int(_BURST_QUANTILE * len(lengths)), len(lengths) - 1)]
