"""Loss-based control as in GCC (section 6), and the length of loss bursts."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from wax.congestion.pacer import ENOUGH_BPS

if TYPE_CHECKING:
    from collections.abc import Collection

    from wax.congestion.control import Delivery

_BUCKET_S: Final = 0.25
"""Packets are counted in intervals of this length."""
_MEMORY_S: Final = 10.0
"""Loss is averaged over this time; RTCP reports cover about 5 s (RFC 3550, 6.2)."""
_OUTAGE_S: Final = 0.5
"""Consecutive losses that span this time are an outage, which says nothing about the rate: a full
queue lets some of the sound through. As long as the shortest feedback timeout."""
_HIGH_LOSS_SHARE: Final = 0.4
"""Loss that lowers the rate: no usable radio loses so much; a queue shows as delay. GCC: 10 %."""
_HIGH_LOSS_S: Final = 2.0
"""High loss is judged over this time, and the rate is held for as long after a fall."""
_MIN_PACKETS: Final = 40
"""Minimum packets to judge by: the standard error of 40 % of 40 is 8 %."""
DECREASE_FACTOR: Final = 0.9
"""Share of a full link's delivery rate to use, so that the queue drains. GCC's beta: 0.85."""
_BURSTS: Final = 200
"""At most this many loss bursts are kept. It bounds memory."""
_BURSTS_S: Final = 30.0
"""How long they are kept."""
_BURST_QUANTILE: Final = 0.95
"""Share of the bursts that redundancy must repair (RFC 2198)."""

_STARTING_RATE_BPS: Final = 5_000_000.0
"""Rate before the first report. If it is too high, only an overflowing queue shows that."""
_MIN_RATE_BPS: Final = 30_000.0
"""Lowest rate: sound and an occasional smallest picture."""
LOW_LOSS_SHARE: Final = 0.02
"""Less loss is no congestion. GCC: 2 %."""
_REPORTED_LOSS_SHARE: Final = 0.10
"""Above this loss the rate falls. GCC: 10 %."""
_INCREASE_PER_S: Final = 0.08
"""Increase per second. GCC: 5 % a report."""
_MAX_REPORT_S: Final = 2.0
"""One report counts for at most this long. Ours: twice a browser's interval."""
_DECREASE_SHARE: Final = 0.5
"""The rate falls by this fraction of the lost share, so by at most this. GCC: 1 - 0.5 p."""


@dataclass(slots=True)
class _Bucket:
    start_s: float
    packets: int = 0
    lost: int = 0
    arrived_bytes: int = 0


class LossControl:
    """Fed with every packet in the order of sending; `now_s` never falls."""

    def __init__(self) -> None:
        self.sound_has_feedback = True
        """Only feedback on the sound shows whether consecutive losses are an outage."""
        self._gap: list[Delivery] = []  # lost since the last arrival; in an outage, only the first
        self._buckets: deque[_Bucket] = deque()
        self._bursts: deque[tuple[float, int]] = deque(maxlen=_BURSTS)  # when each ended, length
        self._in_a_row = 0
        self._judged_from_s = -math.inf
        self.congested = False
        """Whether loss has lowered the rate, and perhaps not yet far enough."""

    @property
    def share(self) -> float:
        return _lost_share(self._buckets)

    @property
    def burst(self) -> int:
        """As in `LinkEstimate`; sound packets are sparser, so their bursts are shorter."""
        lengths = sorted(length for _, length in self._bursts)
        at = min(int(_BURST_QUANTILE * len(lengths)), len(lengths) - 1)
        return lengths[at] if lengths else self._in_a_row

    def add(self, packet: Delivery, now_s: float) -> None:
        """Count a packet; a lost one only once the next arrival shows that it was no outage."""
        if packet.arrived_s is None and self.sound_has_feedback:
            self._gap.append(packet)
            if self._is_outage(packet.sent_s):
                del self._gap[1:]
            return
        if self._gap and not self._is_outage(packet.sent_s):
            for lost in self._gap:
                self._count(lost, now_s)
        self._gap.clear()
        self._count(packet, now_s)

    def judge(self, rate_bps: float, *, queue_stands: bool, now_s: float) -> float | None:
        """Return the rate after a fall because of loss, None if it stays.

        High loss without a standing queue means that the link's queue is too short to measure. A
        standing queue loses packets too, but its delay is the better signal.
        """
        if queue_stands:
            self.congested, self._judged_from_s = False, now_s
            return None
        if now_s - self._judged_from_s < _HIGH_LOSS_S:
            return None
        recent = [one for one in self._buckets if one.start_s >= now_s - _HIGH_LOSS_S]
        packets = sum(one.packets for one in recent)
        self.congested = packets >= _MIN_PACKETS and _lost_share(recent) > _HIGH_LOSS_SHARE
        if not self.congested:
            return None
        self._judged_from_s = now_s
        came_bps = sum(one.arrived_bytes for one in recent) * 8 / _HIGH_LOSS_S
        return max(DECREASE_FACTOR * came_bps, (1 - _DECREASE_SHARE) * rate_bps)

    def forget(self, now_s: float) -> None:
        """Reset the counts, but keep the burst lengths."""
        self._buckets.clear()
        self.congested, self._judged_from_s = False, now_s

    def _is_outage(self, until_s: float) -> bool:
        return until_s - self._gap[0].sent_s >= _OUTAGE_S

    def _count(self, packet: Delivery, now_s: float) -> None:
        if not self._buckets or now_s >= self._buckets[-1].start_s + _BUCKET_S:
            self._buckets.append(_Bucket(now_s))
            while self._buckets[0].start_s < now_s - _MEMORY_S:
                self._buckets.popleft()
        bucket, is_lost = self._buckets[-1], packet.arrived_s is None
        bucket.packets += 1
        bucket.lost += is_lost
        bucket.arrived_bytes += 0 if is_lost else packet.size_bytes
        if packet.kind == "audio" or not self.sound_has_feedback:
            if is_lost:
                self._in_a_row += 1
            elif self._in_a_row:
                self._bursts.append((now_s, self._in_a_row))
                self._in_a_row = 0
            while self._bursts and self._bursts[0][0] < now_s - _BURSTS_S:
                self._bursts.popleft()


def _lost_share(buckets: Collection[_Bucket]) -> float:
    packets = sum(one.packets for one in buckets)
    return sum(one.lost for one in buckets) / packets if packets else 0.0


class LossBasedControl:
    """Adapts the rate to the loss in receiver reports (RFC 3550, 6.4.1); `now_s` never falls."""

    def __init__(self, rate_bps: float = _STARTING_RATE_BPS, max_bps: float = ENOUGH_BPS) -> None:
        self._max_bps = max_bps
        self.rate_bps = rate_bps
        self._reported_s: float | None = None

    def reported(self, lost: float, now_s: float, came_bps: float = math.inf) -> None:
        """Handle a lost share from 0 to 1; if it is high, the rate falls to `came_bps` at most."""
        before_s = now_s if self._reported_s is None else self._reported_s
        self._reported_s = now_s
        if lost > _REPORTED_LOSS_SHARE:
            self._set(min(self.rate_bps * (1 - _DECREASE_SHARE * lost), came_bps))
        elif lost < LOW_LOSS_SHARE:
            elapsed_s = min(now_s - before_s, _MAX_REPORT_S)
            self._set(self.rate_bps * (1 + _INCREASE_PER_S * elapsed_s))

    def _set(self, rate_bps: float) -> None:
        self.rate_bps = min(max(rate_bps, _MIN_RATE_BPS), self._max_bps)
