"""How much is lost, and how many in a row."""

from __future__ import annotations

import math
from collections import deque
from typing import Final, NamedTuple

_BUCKET_S: Final = 0.25
_MEMORY_S: Final = 10.0
_RUNS: Final = 200
_RUNS_S: Final = 30.0
_USUAL_GAIN: Final = _BUCKET_S / 20
_USUAL_FIRST: Final = 8
_MUCH: Final = 0.12
_LATELY_S: Final = 2.0
_VERY_MUCH: Final = 0.4
_BRIEFLY_S: Final = 1.0
_PACKETS: Final = 40
_CARE: Final = 0.9
_QUANTILE: Final = 0.95


class Fate(NamedTuple):
    """What became of the packets that were told of in a stretch of time."""

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
    """Told of every packet in the order of their sending; `now_s` never falls."""

    def __init__(self) -> None:
        self._buckets: deque[_Bucket] = deque()
        self._runs = _Runs()
        self._sound_runs = _Runs()
        self._usual = 0.0
        self._closed = 0
        self._much = False
        self._from_s = -math.inf

    @property
    def share(self) -> float:
        """What of the packets was lost in the last 10 s."""
        return self._since(-math.inf).lost_share

    @property
    def much(self) -> bool:
        """Whether the rate fell because of loss, and nothing yet shows that it was enough."""
        return self._much

    def add(self, size_bytes: int, *, lost: bool, sound: bool, now_s: float) -> None:
        if not self._buckets or now_s >= self._buckets[-1].start_s + _BUCKET_S:
            self._close(now_s)
            self._buckets.append(_Bucket(now_s))
        bucket = self._buckets[-1]
        bucket.packets += 1
        if lost:
            bucket.lost += 1
        else:
            bucket.arrived_bytes += size_bytes
        self._runs.add(lost=lost, now_s=now_s)
        if sound:
            self._sound_runs.add(lost=lost, now_s=now_s)

    def judge(self, rate_bps: float, *, queue_stands: bool, now_s: float) -> float | None:
        """Return to what the rate falls because much is lost, None where it stays.

        Much is more than 12 % beyond twice what is usual, over 2 s, or 40 % over one: the queue of
        the link is too short to be seen. Where one stands it loses too, but tells more.
        """
        if queue_stands:
            self._much, self._from_s = False, now_s
            return None
        briefly = self._since(max(now_s - _BRIEFLY_S, self._from_s))
        if briefly.packets >= _PACKETS and briefly.lost_share > _VERY_MUCH:
            return self._fallen_bps(briefly.arrived_bytes * 8 / _BRIEFLY_S, rate_bps, now_s)
        if now_s - self._from_s < _LATELY_S:
            return None
        lately = self._since(max(now_s - _LATELY_S, self._from_s))
        self._much = lately.packets >= _PACKETS and lately.lost_share > _MUCH + 2 * self._usual
        if not self._much:
            return None
        return self._fallen_bps(lately.arrived_bytes * 8 / _LATELY_S, rate_bps, now_s)

    def burst(self) -> int:
        """Return how many are lost in a row at most (95 of 100 times), 0 when none are.

        Of the sound, where sound is sent: its packets are fewer and so fewer of them in a row.
        """
        return self._sound_runs.longest() if self._sound_runs.told else self._runs.longest()

    def forget(self, now_s: float) -> None:
        """Begin to count anew; how long rows are stays known."""
        self._buckets.clear()
        self._much, self._from_s = False, now_s

    def _fallen_bps(self, came_bps: float, rate_bps: float, now_s: float) -> float:
        self._much, self._from_s = True, now_s
        return max(_CARE * came_bps, rate_bps / 2)

    def _since(self, from_s: float) -> Fate:
        packets = lost = arrived_bytes = 0
        for bucket in reversed(self._buckets):
            if bucket.start_s < from_s:
                break
            packets += bucket.packets
            lost += bucket.lost
            arrived_bytes += bucket.arrived_bytes
        return Fate(packets, lost, arrived_bytes)

    def _close(self, now_s: float) -> None:
        if self._buckets:
            bucket = self._buckets[-1]
            self._closed += 1
            gain = max(_USUAL_GAIN, 1 / (_USUAL_FIRST + self._closed))
            self._usual += gain * (bucket.lost / bucket.packets - self._usual)
        while self._buckets and self._buckets[0].start_s < now_s - _MEMORY_S:
            self._buckets.popleft()


class _Runs:
    """Lengths of rows of lost packets."""

    def __init__(self) -> None:
        self._ended: deque[tuple[float, int]] = deque(maxlen=_RUNS)
        self._length = 0
        self.told = False

    def add(self, *, lost: bool, now_s: float) -> None:
        self.told = True
        if lost:
            self._length += 1
        elif self._length:
            self._ended.append((now_s, self._length))
            self._length = 0
        while self._ended and self._ended[0][0] < now_s - _RUNS_S:
            self._ended.popleft()

    def longest(self) -> int:
        lengths = sorted(length for _, length in self._ended)
        if not lengths:
            return self._length
        return lengths[min(int(_QUANTILE * len(lengths)), len(lengths) - 1)]
