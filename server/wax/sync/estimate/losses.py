"""How much is lost, and how many in a row."""

from __future__ import annotations

from collections import deque
from typing import Final, NamedTuple

_BUCKET_S: Final = 0.25
_MEMORY_S: Final = 10.0
_RUNS: Final = 200
_RUNS_S: Final = 30.0
_USUAL_GAIN: Final = _BUCKET_S / 20
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


class Losses:
    """Told of every packet in the order of their sending; `now_s` never falls."""

    def __init__(self) -> None:
        self._buckets: deque[_Bucket] = deque()
        self._runs = _Runs()
        self._sound_runs = _Runs()
        self._usual = 0.0

    @property
    def usual(self) -> float:
        """The share that is lost when nothing is wrong (a mean over 20 s)."""
        return self._usual

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

    def since(self, from_s: float) -> Fate:
        """Return what was told of since then, as far as is remembered (10 s)."""
        packets = lost = arrived_bytes = 0
        for bucket in reversed(self._buckets):
            if bucket.start_s < from_s:
                break
            packets += bucket.packets
            lost += bucket.lost
            arrived_bytes += bucket.arrived_bytes
        return Fate(packets, lost, arrived_bytes)

    def burst(self) -> int:
        """Return how many are lost in a row at most (95 of 100 times), 0 when none are.

        Of the sound, where sound is sent: its packets are fewer and so fewer of them in a row.
        """
        return self._sound_runs.longest() if self._sound_runs.told else self._runs.longest()

    def forget(self) -> None:
        """Begin to count anew; how long rows are stays known."""
        self._buckets.clear()

    def _close(self, now_s: float) -> None:
        if self._buckets:
            bucket = self._buckets[-1]
            self._usual += _USUAL_GAIN * (bucket.lost / bucket.packets - self._usual)
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
