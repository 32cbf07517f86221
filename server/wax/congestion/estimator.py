"""What one viewer's link carries, from what comes back of what was sent."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from wax.congestion.delivery import LinkEstimate, Train
from wax.congestion.delivery_rate import DeliveryRate
from wax.congestion.dispersion import DispersionEstimator
from wax.congestion.feedback_timeout import FeedbackTimeout
from wax.congestion.jitter import Jitter
from wax.congestion.loss import LossControl
from wax.congestion.packet_size import payload_bytes, train_payload_bytes
from wax.congestion.packet_trains import PacketTrain, PacketTrains
from wax.congestion.probing import ENOUGH_BPS, STARTING_RATE_BPS, Prober
from wax.congestion.queuing_delay import QueuingDelay
from wax.congestion.send_history import SendHistory
from wax.congestion.standing_queue import StandingQueue

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.congestion.delivery import Delivery, LinkState

_LEAST_BPS: Final = 8_000.0
_MOST_BPS: Final = 50_000_000.0
_CARE: Final = 0.9
"""What of a rate that was measured at its limit is used, so that the queue empties."""
_WORTH: Final = 1.03

_STARTING_S: Final = 3.0
_TRAIN_PACKETS: Final = 4
_FIRST_TRAINS: Final = 3
_SLOW_S: Final = 0.010

_CREEP_PER_S: Final = 0.15
_CREEP_USED: Final = 4.0
_REFUTED: Final = 0.85
_CALM_S: Final = 2.0
_CEILING: Final = 1.05
_CEILING_S: Final = 20.0
_LOSSY: Final = 0.1
_HINDSIGHT_S: Final = 1.0
_LONGER_WAY_S: Final = 3.0
_FEW_LOST: Final = 0.02
_LONG_SILENCE_S: Final = 3.0

_MOST_QUEUE_MS: Final = 10_000.0
_OLD_S: Final = 60.0
_MOST_CLOCK_S: Final = 1e11
_MOST_BYTES: Final = 65_535


class LinkEstimator:
    """Follows the rate by trains of packets, and the queue by how long packets take.

    Falls at once, to what comes out of a full queue; rises by pictures that leave faster than the
    rate. Loss alone is no sign, unless it is much and more than usual. Whatever is reported, the
    rate stays between 8 kbit/s and 50 Mbit/s and nothing is raised; time that runs back stands.
    """

    def __init__(self) -> None:
        self._now_s = 0.0
        self._rate_bps = STARTING_RATE_BPS
        self._starting_until_s = math.inf
        self._origin_s: float | None = None
        self._log = SendHistory()
        self._waiting = QueuingDelay()
        self._busy = DeliveryRate()
        self._queue = StandingQueue()
        self._jitter = Jitter()
        self._losses = LossControl()
        self._evidence = DispersionEstimator()
        self._trains = PacketTrains(self._log)
        self._prober = Prober()
        self._silence = FeedbackTimeout()
        self._number = 0
        self._assumed = True
        self._crept_s = 0.0
        self._fell_s = -math.inf
        self._before_bps = 0.0
        self._counted_s = -math.inf
        self._lost_bytes = 0
        self._ceiling_bps = math.inf
        self._newest: tuple[float, float] | None = None  # when it was sent, how long it waited

    def sent(self, size_bytes: int, now_s: float) -> None:
        """Count a datagram that leaves, headers and all; `now_s` as in its `Delivery.sent_s`."""
        now_s = self._pass(now_s)
        if 0 < size_bytes <= _MOST_BYTES:
            self._log.add(size_bytes, now_s)
            self._silence.sent(now_s)

    def round_trip(self, round_trip_s: float, now_s: float) -> None:
        """Count a round trip that was measured, of any length."""
        self._pass(now_s)
        self._silence.round_trip(round_trip_s)

    def train(self, size_bytes: int, now_s: float) -> Train:
        """Decide how a picture of `size_bytes` leaves that is about to be sent."""
        now_s = self._pass(now_s)
        self._number += 1
        pace_bps, many = self._rate_bps, False
        if not self._congested and not self._silence.blind(now_s):
            pace_bps, many = self._prober.pace_bps(
                size_bytes,
                self._rate_bps,
                starting=self._starting,
                lossy=self._losses.share > _LOSSY,
                now_s=now_s,
            )
        payload = payload_bytes(self._rate_bps)
        if many:
            payload = train_payload_bytes(self._rate_bps, size_bytes, _TRAIN_PACKETS)
        packets = math.ceil(size_bytes / payload)
        if pace_bps > self._rate_bps and packets > 1:
            self._trains.expect(self._number, packets)
        return Train(self._number, pace_bps, payload)

    def delivered(self, deliveries: Sequence[Delivery], now_s: float) -> None:
        """Count what a feedback told of."""
        now_s = self._pass(now_s)
        known = sorted((one for one in deliveries if self._sane(one)), key=lambda one: one.sent_s)
        if not known:
            return
        if self._silence.lasts_s(now_s) > _LONG_SILENCE_S:
            self._begin_again()
        self._silence.heard()
        if self._starting_until_s == math.inf:
            self._starting_until_s = now_s + _STARTING_S
        for delivery in known:
            self._count(delivery)
        self._judge_queue()
        fallen_bps = self._losses.judge(
            self._rate_bps, queue_stands=self._queue.since_s is not None, now_s=now_s
        )
        if fallen_bps is not None:
            self._fall(fallen_bps)
        if not self._congested:
            self._rise()

    def estimate(self, now_s: float) -> LinkEstimate:
        """Return what is known now."""
        now_s = self._pass(now_s)
        round_trip_s = self._silence.round_trip_s
        return LinkEstimate(
            state=self._state(now_s),
            rate_bps=self._rate_bps,
            used_bps=self._log.used_bps(now_s),
            queue_ms=self._queue_ms(now_s),
            jitter_ms=self._jitter.quantile_ms(0.99),
            lost=self._losses.share,
            burst=self._losses.burst(),
            round_trip_ms=None if round_trip_s is None else round_trip_s * 1000,
            assumed=self._assumed and self._starting,
        )

    @property
    def _starting(self) -> bool:
        return self._now_s < self._starting_until_s

    @property
    def _congested(self) -> bool:
        return self._queue.since_s is not None or self._losses.much

    def _state(self, now_s: float) -> LinkState:
        if self._silence.blind(now_s):
            return "blind"
        if self._congested:
            return "congested"
        return "starting" if self._starting else "steady"

    def _queue_ms(self, now_s: float) -> float:
        if self._newest is None:
            return 0.0
        sent_s, waited_s = self._newest
        queue_s = self._log.queue_s(waited_s, sent_s, now_s, self._rate_bps)
        return min(queue_s * 1000, _MOST_QUEUE_MS)

    def _pass(self, now_s: float) -> float:
        if self._now_s < now_s < math.inf:
            self._now_s = now_s
        return self._now_s

    def _sane(self, delivery: Delivery) -> bool:
        return (
            0 < delivery.size_bytes <= _MOST_BYTES
            and self._now_s - _OLD_S < delivery.sent_s <= self._now_s
            and (delivery.arrived_s is None or abs(delivery.arrived_s) < _MOST_CLOCK_S)
        )

    def _count(self, delivery: Delivery) -> None:
        sound = delivery.kind == "audio"
        lost = delivery.arrived_s is None
        self._losses.add(delivery.size_bytes, lost=lost, sound=sound, now_s=self._now_s)
        if lost:
            self._lost_bytes += delivery.size_bytes
        if delivery.arrived_s is not None:
            if self._origin_s is None:
                self._origin_s = delivery.arrived_s - delivery.sent_s
            arrived_s = delivery.arrived_s - self._origin_s
            waited_s = self._waiting.add(
                delivery.sent_s, arrived_s, delivery.size_bytes, self._rate_bps
            )
            self._newest = (delivery.sent_s, waited_s)
            reached_s = delivery.sent_s + self._waiting.least_s
            # With it came what left before it and was not marked, the data channels' and RTCP's.
            size_bytes = self._log.between(self._counted_s, delivery.sent_s) - self._lost_bytes
            self._busy.add(reached_s, arrived_s, max(size_bytes, delivery.size_bytes))
            self._counted_s, self._lost_bytes = max(self._counted_s, delivery.sent_s), 0
            if sound and self._queue.since_s is None:
                self._jitter.add(arrived_s - delivery.sent_s, self._now_s)
        for probe in self._trains.add(delivery):
            self._judge_train(probe)

    def _judge_train(self, probe: PacketTrain) -> None:
        passage = probe.passage(self._now_s)
        if passage is None:
            return
        rough_s = self._waiting.rough_s
        self._evidence.add(passage, rough_s)
        if not self._starting or len(self._evidence) > _FIRST_TRAINS:
            return
        # What the rate was is a mere assumption, so one train that is clearly slow is enough.
        if passage.came_in_s - passage.sent_in_s <= 3 * rough_s + _SLOW_S:
            self._assumed = False
            return
        came_bps = probe.trimmed_bps()
        if came_bps is not None:
            self._assumed = False
            self._fall(_CARE * came_bps)

    def _judge_queue(self) -> None:
        stood = self._queue.since_s is not None
        if not self._queue.look(self._waiting, self._rate_bps, self._now_s):
            self._waiting.settle()
            return
        if not stood:
            self._before_bps = self._rate_bps
            limit_s = self._waiting.least_s + self._queue.limit_s(self._waiting, self._rate_bps)
            self._jitter.forget_since(self._now_s - _HINDSIGHT_S, limit_s)
        came_bps = self._busy.rate_bps()
        if came_bps is not None and _CARE * came_bps < self._rate_bps:
            self._ceiling_bps = _CEILING * came_bps
            self._fall(_CARE * came_bps)
        elif (
            self._queue.level_for_s(self._now_s) > _LONGER_WAY_S and self._losses.share < _FEW_LOST
        ):
            # A queue would have grown or shrunk by now: it is the way that has become longer.
            self._waiting.relearn()
            self._queue.clear()
            self._set(max(self._rate_bps, self._before_bps))

    def _rise(self) -> None:
        now_s, rough_s = self._now_s, self._waiting.rough_s
        least_bps = self._evidence.least_bps(rough_s, bold=self._starting)
        if least_bps > _WORTH * self._rate_bps:
            self._prober.risen(now_s)
            self._set(least_bps)
        elif self._evidence.most_bps(rough_s) < _REFUTED * self._rate_bps:
            self._set(self._evidence.most_bps(rough_s))
        elif now_s - self._fell_s > _CALM_S:
            # Jitter hides some of what is carried: what is likely is tried, with care.
            likely_bps = self._evidence.likely_bps(rough_s)
            if now_s - self._fell_s < _CEILING_S:
                likely_bps = min(likely_bps, self._ceiling_bps)
            likely_bps = min(likely_bps, _CREEP_USED * self._log.used_bps(now_s), ENOUGH_BPS)
            step = 1 + _CREEP_PER_S * min(now_s - self._crept_s, 1.0)
            self._set(max(self._rate_bps, min(step * self._rate_bps, likely_bps)))
        self._crept_s = now_s
        if now_s - self._fell_s > _CALM_S and self._losses.share < _FEW_LOST:
            # What was sent the second before last has come through, and no queue stands.
            carried_bps = 8 * self._log.between(now_s - _CALM_S, now_s - _CALM_S / 2)
            self._set(max(self._rate_bps, _CARE * carried_bps / (_CALM_S / 2)))
        if self._rate_bps >= ENOUGH_BPS:
            self._starting_until_s = min(self._starting_until_s, now_s)

    def _fall(self, rate_bps: float) -> None:
        if rate_bps >= self._rate_bps:
            return
        self._set(rate_bps)
        self._fell_s = self._now_s
        self._starting_until_s = min(self._starting_until_s, self._now_s)
        self._evidence.clear()
        self._trains.clear()
        self._prober.fallen(self._now_s)

    def _begin_again(self) -> None:
        """After a long silence nothing is known any more, but how little it was before."""
        self._set(min(self._rate_bps, STARTING_RATE_BPS))
        self._starting_until_s = math.inf
        self._waiting.relearn()
        self._busy.clear()
        self._queue.clear()
        self._evidence.clear()
        self._trains.clear()
        self._losses.forget(self._now_s)

    def _set(self, rate_bps: float) -> None:
        self._rate_bps = min(max(rate_bps, _LEAST_BPS), _MOST_BPS)
