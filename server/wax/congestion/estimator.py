"""Estimates the rate, queue, jitter and loss of one viewer's link from its feedback.

It starts at `pacer.STARTING_RATE_BPS`; without transport-wide feedback, at `loss`'s starting rate.
"""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING, Final

from wax.congestion.control import LinkEstimate, Train
from wax.congestion.delivery_rate import (
    Arrival,
    DeliveryRate,
    DispersionEstimator,
    PacketTrains,
    steady_bps,
)
from wax.congestion.feedback import FeedbackTimeout
from wax.congestion.loss import DECREASE_FACTOR, LOW_LOSS_SHARE, LossBasedControl, LossControl
from wax.congestion.pacer import ENOUGH_BPS, STARTING_RATE_BPS, Prober
from wax.congestion.queuing_delay import MAX_MS, Jitter, QueuingDelay
from wax.congestion.send_history import SendHistory
from wax.congestion.wire_cost import payload_bytes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.congestion.control import Delivery, Kind, LinkState

_MIN_RATE_BPS: Final = 8_000.0
"""Lowest rate; the smallest encoding of the sound takes 13 kbit/s."""
_STARTUP_S: Final = 3.0
"""Startup ends this long after the first feedback. BBR's ends when the rate stays level."""
_PROBE_PACKETS: Final = 4
"""A probing picture has at least this many packets. libwebrtc's probe clusters have 5."""
_STARTUP_TRAINS: Final = 3
"""Only this many first trains may lower the assumed rate."""
_STARTUP_SLOW_S: Final = 0.010
"""A first train that is spread by this much shows that the link is slower than assumed."""
_STARTUP_SLOW_NOISES: Final = 3.0
"""Plus this multiple of the delay noise (99.7 % of a normal distribution)."""
_INCREASE_PER_S: Final = 0.15
"""Increase per second towards the likely rate. GCC's multiplicative increase: 8 % (5.5)."""
_TRIAL_FACTOR: Final = 1.5
"""Multiple of the rate in use that is assumed when a picture is tried. As GCC's bound (5.5)."""
_HOLD_S: Final = 1.0
"""For this long after a fall, only a train raises the rate. GCC holds until the queue is empty
(5.5)."""
_CARRIED_AFTER_S: Final = 1.0
"""Without a queue, everything sent in the second that ended this long ago has arrived, so the link
carries that rate. Later packets may still be in flight."""
_CARRIED_SHARE: Final = 0.95
"""The share of that rate to rely on. With 0.9 a modem's estimate may stay below its sound after a
download; with 1.0, pictures are tried on 24 kbit/s until the sound is queued."""
_JITTER_HINDSIGHT_S: Final = 1.0
"""Delays up to this long before a queue is found are not jitter: finding it takes two feedback
packets."""
_ROUTE_CHANGE_S: Final = 3.0
"""A standing delay that stays level for this long means a longer route: a queue grows or shrinks.
LEDBAT waits until its base delay expires, BBR drains the queue to check (ProbeRTT)."""
_RESTART_AFTER_S: Final = 3.0
"""After this long without feedback the estimate starts over."""
_REPORTS: Final = 2
"""Loss is averaged over this many reports: about 10 s, as with transport-wide feedback. libwebrtc
sends one every 5 s. One report measures 5 % loss as 2.6 to 8.2 %, two as 3.3 to 7.0 %."""
_MAX_DELIVERY_AGE_S: Final = 60.0
"""Feedback about older packets is ignored as invalid."""
_MAX_CLOCK_S: Final = 1e11
"""Later arrival times are ignored too: below this, floats are finer than a tick."""
_MAX_DATAGRAM_BYTES: Final = 65_535
"""No datagram is longer (RFC 768)."""


class LinkEstimator:
    """Estimates the link from the calls of `CongestionControl`; a `now_s` that falls is ignored.

    Whatever is reported, the rate stays between 8 kbit/s and 20 Mbit/s, and nothing raises.
    Some browsers, such as Firefox 140, send no feedback on the sound's packets. Then sound is a
    known load between the pictures, receiver reports give its loss, and the first packet of each
    picture, which queues behind no other, gives the jitter.
    """

    def __init__(self) -> None:
        self._has_feedback: bool | None = None  # transport-wide, of any stream
        self._reported: deque[float] = deque(maxlen=_REPORTS)
        self._loss_based: LossBasedControl | None = None  # while nothing but loss is reported
        self._jitter_train: int | None = None
        self._now_s = 0.0
        self._rate_bps = STARTING_RATE_BPS
        self._startup_until_s = math.inf
        self._history = SendHistory()
        self._delay = QueuingDelay()
        self._delivery_rate = DeliveryRate()
        self._jitter = Jitter()
        self._loss = LossControl()
        self._dispersion = DispersionEstimator()
        self._trains = PacketTrains()
        self._prober = Prober()
        self._timeout = FeedbackTimeout()
        self._number = 0
        self._assumed = True
        self._increased_s = 0.0
        self._fell_s = -math.inf
        self._before_queue_bps = 0.0
        self._counted_s = -math.inf
        self._lost_bytes = 0
        self._came_bytes = 0
        self._newest: tuple[float, float] | None = None  # time queued, time sent

    def sent(self, size_bytes: int, now_s: float, *, has_feedback: bool = True) -> None:
        """Count a datagram; `now_s` is its `Delivery.sent_s`."""
        now_s = self._pass(now_s)
        if 0 < size_bytes <= _MAX_DATAGRAM_BYTES:
            self._history.add(size_bytes, now_s)
            if has_feedback and self._has_feedback is not False:
                self._timeout.sent(now_s)

    def round_trip(self, round_trip_s: float, now_s: float) -> None:
        self._pass(now_s)
        self._timeout.round_trip(round_trip_s)

    def negotiated(self, *, has_feedback: bool, kind: Kind) -> None:
        """Handle whether this stream has transport-wide feedback; one such stream is enough."""
        if kind == "audio":
            self._loss.sound_has_feedback = has_feedback
        any_has_feedback = self._has_feedback or has_feedback
        if any_has_feedback == self._has_feedback:
            return
        self._has_feedback = any_has_feedback
        self._loss_based = None if any_has_feedback else LossBasedControl()
        self._startup_until_s = math.inf if any_has_feedback else -math.inf
        self._set(STARTING_RATE_BPS if self._loss_based is None else self._loss_based.rate_bps)

    def reported(self, lost: float, now_s: float, kind: Kind) -> None:
        """Handle the loss in a receiver report, unless transport-wide feedback covers it."""
        now_s = self._pass(now_s)
        is_told = kind == "video" or self._loss.sound_has_feedback
        if (is_told and self._has_feedback is not False) or not 0 <= lost <= 1:
            return
        self._reported.append(lost)
        is_silent = self._timeout.is_idle(now_s) or self._timeout.is_over(now_s)
        if self._has_feedback and not is_silent:
            return
        if self._loss_based is None:
            self._loss_based = LossBasedControl(self._rate_bps, max_bps=self._rate_bps)
        # Pictures would fill the rate again; sound alone does not.
        came_bps = (1 - lost) * self._history.used_bps(now_s) if self._has_feedback else math.inf
        self._loss_based.reported(lost, now_s, came_bps)
        self._set(self._loss_based.rate_bps)

    def plan_train(self, size_bytes: int, now_s: float) -> Train:
        now_s = self._pass(now_s)
        self._number += 1
        pace_bps, payload = self._rate_bps, payload_bytes(self._rate_bps)
        if self._has_feedback is not False and self._state in ("starting", "steady"):
            pace_bps = self._prober.pace_bps(
                size_bytes, self._rate_bps, startup=self._startup, now_s=now_s
            )
        if pace_bps > self._rate_bps:
            payload = payload_bytes(self._rate_bps, math.ceil(size_bytes / _PROBE_PACKETS))
            if (packets := math.ceil(size_bytes / payload)) > 1:
                self._trains.register(self._number, packets)
        return Train(self._number, pace_bps, payload)

    def try_more(self, now_s: float) -> None:
        """Assume that the link carries a picture on trial; if not, a queue will show it."""
        now_s = self._pass(now_s)
        if not self._congested:
            self._set(max(self._rate_bps, _TRIAL_FACTOR * self._history.used_bps(now_s)))

    def delivered(self, deliveries: Sequence[Delivery], now_s: float) -> None:
        now_s = self._pass(now_s)
        known = sorted((one for one in deliveries if self._sane(one)), key=lambda one: one.sent_s)
        if not known:
            return
        if self._timeout.feedback_arrived(now_s) > _RESTART_AFTER_S:
            self._restart()
        self._loss_based = None
        if self._startup_until_s == math.inf:
            self._startup_until_s = now_s + _STARTUP_S
        for delivery in known:
            self._count(delivery)
        self._judge_queue()
        fallen_bps = self._loss.judge(self._rate_bps, queue_stands=self._delay.stands, now_s=now_s)
        if fallen_bps is not None:
            self._decrease(fallen_bps)
        if not self._congested:
            self._increase()

    def estimate(self, now_s: float) -> LinkEstimate:
        now_s = self._pass(now_s)
        queue_s, lost, burst = 0.0, self._lost, self._loss.burst
        if self._newest is not None:
            queue_s = self._history.queue_s(*self._newest, now_s, self._rate_bps)
        if self._reported:
            # Reports give no burst lengths, but the pictures' packets crossed the same link.
            burst = max(burst, 1) if lost > 0 else 0
        return LinkEstimate(
            state=self._state,
            rate_bps=self._rate_bps,
            used_bps=self._history.used_bps(now_s),
            queue_ms=min(queue_s * 1000, MAX_MS),
            jitter_ms=self._jitter.ms,
            lost=lost,
            burst=burst,
            round_trip_ms=self._timeout.round_trip_ms,
            assumed=self._assumed and self._startup,
        )

    @property
    def _startup(self) -> bool:
        return self._now_s < self._startup_until_s

    @property
    def _congested(self) -> bool:
        if self._timeout.is_idle(self._now_s):
            return False  # with nothing sent, no feedback would report that congestion ended
        return self._delay.stands or self._loss.congested

    @property
    def _lost(self) -> float:
        if self._reported:
            return sum(self._reported) / len(self._reported)
        return self._loss.share

    @property
    def _state(self) -> LinkState:
        if self._timeout.is_over(self._now_s):
            return "blind"
        if self._congested:
            return "congested"
        return "starting" if self._startup else "steady"

    def _pass(self, now_s: float) -> float:
        if self._now_s < now_s < math.inf:
            self._now_s = now_s
        return self._now_s

    def _sane(self, delivery: Delivery) -> bool:
        return (
            0 < delivery.size_bytes <= _MAX_DATAGRAM_BYTES
            and self._now_s - _MAX_DELIVERY_AGE_S < delivery.sent_s <= self._now_s
            and (delivery.arrived_s is None or abs(delivery.arrived_s) < _MAX_CLOCK_S)
        )

    def _count(self, delivery: Delivery) -> None:
        self._loss.add(delivery, self._now_s)
        arrival, sent_s, size_bytes = None, delivery.sent_s, delivery.size_bytes
        if delivery.arrived_s is None:
            self._lost_bytes += size_bytes
        else:
            # Unmarked packets sent before it count as arrived with it: data channels and RTCP.
            came_bytes = self._history.between(self._counted_s, sent_s) - self._lost_bytes
            self._came_bytes += max(came_bytes, size_bytes)
            self._counted_s, self._lost_bytes = max(self._counted_s, sent_s), 0
            arrival = Arrival(sent_s, delivery.arrived_s, self._came_bytes)
            queued_s = self._delay.add(sent_s, arrival.arrived_s, size_bytes, self._rate_bps)
            self._newest = (queued_s, sent_s)
            self._delivery_rate.add(arrival, self._delay.base_s)
            if self._is_jitter_sample(delivery) and not self._delay.stands:
                self._jitter.add(arrival.arrived_s - arrival.sent_s, self._now_s)
        if delivery.train is not None:
            for arrivals in self._trains.add(delivery.train, arrival):
                self._judge_train(arrivals)

    def _is_jitter_sample(self, delivery: Delivery) -> bool:
        if self._loss.sound_has_feedback:
            return delivery.kind == "audio"
        before = self._jitter_train
        self._jitter_train = before if delivery.train is None else delivery.train
        return self._jitter_train != before

    def _judge_train(self, arrivals: Sequence[Arrival]) -> None:
        spread_s = self._dispersion.add(arrivals, self._now_s)
        if spread_s is None or not self._startup or len(self._dispersion) > _STARTUP_TRAINS:
            return
        # The rate was only assumed, so one clearly slow train is enough to lower it.
        if spread_s <= _STARTUP_SLOW_NOISES * self._delay.noise_s + _STARTUP_SLOW_S:
            self._assumed = False
        elif (came_bps := steady_bps(arrivals)) is not None:
            self._assumed = False
            self._decrease(DECREASE_FACTOR * came_bps)

    def _judge_queue(self) -> None:
        stood = self._delay.stands
        self._delay.judge(self._rate_bps, self._now_s)
        if not self._delay.stands:
            return
        if not stood:
            self._before_queue_bps = self._rate_bps
            limit_s = self._delay.base_s + self._delay.limit_s(self._rate_bps)
            self._jitter.forget_since(self._now_s - _JITTER_HINDSIGHT_S, limit_s)
        came_bps = self._delivery_rate.rate_bps()
        is_level = self._now_s - self._delay.level_from_s > _ROUTE_CHANGE_S
        if came_bps is not None and DECREASE_FACTOR * came_bps < self._rate_bps:
            self._decrease(DECREASE_FACTOR * came_bps)
        elif is_level and self._lost < LOW_LOSS_SHARE:
            self._delay.relearn()
            self._set(max(self._rate_bps, self._before_queue_bps))

    def _increase(self) -> None:
        now_s, noise_s = self._now_s, self._delay.noise_s
        holds = now_s - self._fell_s <= _HOLD_S
        min_bps = self._dispersion.min_bps(noise_s, startup=self._startup)
        if min_bps > self._rate_bps:
            self._prober.changed(now_s, has_risen=True)
            self._set(min_bps)
        elif not holds:
            # Jitter hides part of the rate, so it rises towards the likely rate step by step.
            step = 1 + _INCREASE_PER_S * (now_s - self._increased_s)
            likely_bps = min(step * self._rate_bps, self._dispersion.likely_bps(noise_s))
            self._set(max(self._rate_bps, likely_bps))
        self._increased_s = now_s
        queued_s = 0.0 if self._newest is None else self._newest[0]
        is_empty = queued_s <= self._delay.limit_s(self._rate_bps)
        if is_empty and not holds and self._lost < LOW_LOSS_SHARE:
            carried_bps = self._history.used_bps(now_s - _CARRIED_AFTER_S)
            self._set(max(self._rate_bps, _CARRIED_SHARE * carried_bps))
        if self._rate_bps >= ENOUGH_BPS:
            self._startup_until_s = min(self._startup_until_s, now_s)

    def _decrease(self, rate_bps: float) -> None:
        if rate_bps >= self._rate_bps:
            return
        self._set(rate_bps)
        self._fell_s = self._now_s
        self._startup_until_s = min(self._startup_until_s, self._now_s)
        self._dispersion = DispersionEstimator()
        self._trains.clear()
        self._prober.changed(self._now_s, has_risen=False)

    def _restart(self) -> None:
        """Start over after a long silence, at no more than the previous rate."""
        self._set(min(self._rate_bps, STARTING_RATE_BPS))
        self._startup_until_s = math.inf
        self._delay.relearn()
        self._delivery_rate = DeliveryRate()
        self._dispersion = DispersionEstimator()
        self._trains.clear()
        self._loss.forget(self._now_s)

    def _set(self, rate_bps: float) -> None:
        self._rate_bps = min(max(rate_bps, _MIN_RATE_BPS), ENOUGH_BPS)
