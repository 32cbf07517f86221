"""One direction of a link, without a clock: which packets come out, and when.

Unit tests of congestion control simulate with it, and the emulator in `e2e.link` moves real packets
by it.
"""

from __future__ import annotations

import math
from heapq import heappop, heappush
from typing import TYPE_CHECKING

from tests.link.chance import LossChain, StallClock, jitter_quantile_ms, seeded
from tests.link.counters import Counters
from tests.link.queueing import Backlog, RateTransmitter
from tests.link.schedule import Schedule
from tests.link.trace import TraceTransmitter, read

if TYPE_CHECKING:
    from tests.link.profile import Conditions, DirectionSettings
    from tests.link.queueing import Transmitter


class Direction:
    """Every packet's fate is decided when it arrives, so the model needs no other events.

    Times are monotonic seconds and never fall from one call to the next.
    """

    def __init__(self, settings: DirectionSettings, *, seed: int, way: str, start_s: float) -> None:
        self.counters = Counters()
        self._schedule = Schedule(settings)
        self._trace: TraceTransmitter | None = None
        if settings.trace is not None:
            self._trace = TraceTransmitter(read(settings.trace), start_s)
        self._transmitter: Transmitter = self._trace or RateTransmitter(self._schedule)
        self._backlog = Backlog()
        self._loss = LossChain(seeded(seed, way, "loss"))
        self._jitter = seeded(seed, way, "jitter")
        self._stalls = StallClock(seeded(seed, way, "stalls"), start_s)
        self._on_the_way: list[tuple[float, int, bytes]] = []
        self._latest_s = -math.inf

    def start_changes(self, now_s: float) -> None:
        """Count the times of the changes, and of the trace, from now on.

        Packets inside keep their times.
        """
        self._schedule.start(now_s)
        self._transmitter.start(now_s)

    def arrive(self, packet: bytes, now_s: float) -> None:
        """Accept a packet or drop it; the counters record which."""
        size_bytes = len(packet)
        count = self.counters
        count.packets_in += 1
        count.bytes_in += size_bytes
        limit_bytes = self._limit_bytes(self._schedule.at(now_s))
        if not self._backlog.has_room(size_bytes, limit_bytes, now_s):
            count.queue_drops += 1
            count.queue_drop_bytes += size_bytes
            return
        leaves_s = self._transmitter.finish_s(max(now_s, self._backlog.free_s), size_bytes)
        self._backlog.add(size_bytes, leaves_s)
        count.backlog_peak_bytes = max(count.backlog_peak_bytes, self._backlog.bytes_at(now_s))
        self._carry(packet, leaves_s)

    def next_s(self) -> float:
        """Return when the next packet comes out; infinite when none is inside."""
        return self._on_the_way[0][0] if self._on_the_way else math.inf

    def due(self, now_s: float) -> list[tuple[float, bytes]]:
        """Remove the packets that have reached the other end; return when each was due."""
        out = []
        while self._on_the_way and self._on_the_way[0][0] <= now_s:
            due_s, _, packet = heappop(self._on_the_way)
            out.append((due_s, packet))
            self.counters.packets_out += 1
            self.counters.bytes_out += len(packet)
        return out

    def _carry(self, packet: bytes, leaves_s: float) -> None:
        conditions = self._schedule.at(leaves_s)
        if self._loss.loses(conditions.loss):
            self.counters.losses += 1
            self.counters.loss_bytes += len(packet)
            return
        jitter_ms = jitter_quantile_ms(conditions.jitter, self._jitter.random())
        released_s = self._stalls.release_s(conditions.stalls, leaves_s)
        due_s = released_s + (conditions.delay_ms + jitter_ms) / 1000
        if not conditions.reorder:
            due_s = self._latest_s = max(due_s, self._latest_s)
        heappush(self._on_the_way, (due_s, self.counters.packets_in, packet))

    def _limit_bytes(self, conditions: Conditions) -> float:
        if conditions.queue_bytes is not None:
            return conditions.queue_bytes
        rate_bps = self._trace.mean_bps if self._trace else conditions.rate_bps
        if rate_bps is None or conditions.queue_ms is None:
            return math.inf  # the profile does not allow it
        return rate_bps * conditions.queue_ms / 8000
