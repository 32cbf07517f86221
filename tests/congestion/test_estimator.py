"""The estimator alone, with arrivals, losses, silence and false feedback."""

from __future__ import annotations

import math
import pickle
from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.congestion.control import Delivery, LinkEstimate
from wax.congestion.estimator import LinkEstimator
from wax.congestion.pacer import STARTING_RATE_BPS

if TYPE_CHECKING:
    from collections.abc import Callable

WAY_S = 0.03
FEEDBACK_S = 0.1


class Sound:
    """Sound of 50 packets a second that arrives according to `late_s` and `lost`."""

    def __init__(self, size_bytes: int = 140, *, clock_s: float = 1000.0) -> None:
        self.estimator = LinkEstimator()
        self.now_s = 10.0
        self._size_bytes = size_bytes
        self._clock_s = clock_s
        self._number = 0

    def run(
        self,
        seconds: float,
        *,
        late_s: Callable[[float], float] = lambda _: 0.0,
        lost: Callable[[int], bool] = lambda _: False,
        told: bool = True,
    ) -> LinkEstimate:
        """Send for a while; a late packet holds back those after it."""
        latest_s = -math.inf
        start_s = self.now_s
        while self.now_s < start_s + seconds - 1e-9:
            deliveries = []
            for _ in range(5):
                self.estimator.sent(self._size_bytes, self.now_s)
                latest_s = max(latest_s, self.now_s + WAY_S + late_s(self.now_s - start_s))
                arrived_s = None if lost(self._number) else latest_s + self._clock_s
                deliveries.append(Delivery(self.now_s, arrived_s, self._size_bytes, "audio"))
                self._number += 1
                self.now_s += FEEDBACK_S / 5
            if told:
                self.estimator.delivered(deliveries, self.now_s)
        return self.estimator.estimate(self.now_s)


def test_nothing_is_known_at_first() -> None:
    """Before any feedback the rate is the assumed one, and the estimate says so."""
    estimate = LinkEstimator().estimate(5.0)
    assert estimate.rate_bps == STARTING_RATE_BPS
    assert estimate.assumed
    assert estimate.state == "starting"
    assert estimate.round_trip_ms is None


def test_what_was_sent_in_the_last_second_is_used() -> None:
    """50 packets of 140 bytes a second are 56 kbit/s, and nothing a second later."""
    sound = Sound()
    assert sound.run(2.0).used_bps == pytest.approx(56_000, rel=0.05)
    assert sound.estimator.estimate(sound.now_s + 1.5).used_bps == 0


def test_a_stall_is_no_congestion() -> None:
    """A pause of 150 ms, and the burst after it, change no rate and report no queue."""
    sound = Sound()
    sound.run(2.0)

    def stall(at_s: float) -> float:
        return max(0.0, 0.65 - at_s) if at_s >= 0.5 else 0.0

    estimate = sound.run(2.0, late_s=stall)
    assert estimate.rate_bps == STARTING_RATE_BPS
    assert estimate.queue_ms <= 5.0
    assert estimate.state != "congested"


def test_a_growing_queue_is_found_in_two_feedbacks() -> None:
    """Sound arriving at half its rate is congestion after 200 ms, at 0.9 of what arrives."""
    sound = Sound()
    sound.run(5.0)
    sound.run(0.2, late_s=lambda at_s: at_s)
    estimate = sound.run(0.1, late_s=lambda at_s: at_s + 0.2)
    assert estimate.state == "congested"
    assert estimate.rate_bps == pytest.approx(0.9 * 56_000 / 2, rel=0.15)
    assert estimate.queue_ms > 100


def test_a_queue_that_has_emptied_is_forgotten() -> None:
    """Once packets arrive in time again the link is steady, without a queue."""
    sound = Sound()
    sound.run(5.0)
    sound.run(0.5, late_s=lambda at_s: at_s)
    estimate = sound.run(1.0)
    assert estimate.state == "steady"
    assert estimate.queue_ms <= 20


def test_a_try_assumes_more_than_is_used() -> None:
    """If the rate has fallen below what arrives, a trial assumes half more than arrives."""
    sound = Sound()
    sound.run(5.0)
    fallen = sound.run(0.5, late_s=lambda at_s: at_s)
    sound.estimator.try_more(sound.now_s)
    assert sound.estimator.estimate(sound.now_s).rate_bps == fallen.rate_bps
    steady = sound.run(1.0)
    sound.estimator.try_more(sound.now_s)
    tried = sound.estimator.estimate(sound.now_s)
    assert tried.rate_bps == pytest.approx(1.5 * steady.used_bps)
    assert tried.rate_bps > steady.rate_bps


def test_a_longer_way_is_no_queue() -> None:
    """A new route that takes 80 ms longer is recognised as such within 5 s."""
    sound = Sound()
    sound.run(5.0)
    estimate = sound.run(5.0, late_s=lambda _: 0.08)
    assert estimate.state == "steady"
    assert estimate.rate_bps == STARTING_RATE_BPS


def test_a_drift_of_the_clocks_is_no_queue() -> None:
    """Clocks that drift apart by 100 ppm for two minutes look like at most 5 ms of queue."""
    sound = Sound()
    sound.run(5.0)
    estimate = sound.run(120.0, late_s=lambda at_s: at_s * 100e-6)
    assert estimate.queue_ms <= 5
    assert estimate.jitter_ms <= 5
    assert estimate.rate_bps == STARTING_RATE_BPS


def test_jitter_is_what_most_of_the_sound_needs() -> None:
    """If sound is late by up to 40 ms, the jitter covers 99 of 100 packets within 40 ms."""
    sound = Sound()
    numbers = iter(range(10**6))
    estimate = sound.run(8.0, late_s=lambda _: (next(numbers) * 7 % 41) / 1000)
    assert 35 <= estimate.jitter_ms <= 41


def test_a_queue_does_not_widen_the_jitter_for_long() -> None:
    """Half a second of congestion is answered by sending less, not by a longer buffer."""
    sound = Sound()
    sound.run(10.0)
    sound.run(0.5, late_s=lambda at_s: at_s)
    assert sound.run(3.0).jitter_ms <= 50


def test_random_loss_leaves_the_rate() -> None:
    """5 % lost in rows of two are reported, and cost no rate."""
    estimate = Sound().run(30.0, lost=lambda number: number % 40 < 2)
    assert estimate.rate_bps == STARTING_RATE_BPS
    assert estimate.lost == pytest.approx(0.05, abs=0.01)
    assert estimate.burst == 2


def test_much_loss_lowers_the_rate() -> None:
    """If every second packet is lost the rate falls, but in 0.7 s to no less than half."""
    sound = Sound()
    sound.run(10.0)
    rates = [sound.run(0.1, lost=lambda number: number % 2 == 0).rate_bps for _ in range(40)]
    assert rates[-1] < STARTING_RATE_BPS / 2
    assert all(later >= earlier / 2 for earlier, later in zip(rates, rates[7:], strict=False))


def test_silence_is_told_and_ends_with_the_next_feedback() -> None:
    """Half a second without feedback is blind; the rate stays, and the next feedback ends it."""
    sound = Sound()
    sound.run(5.0)
    assert sound.run(0.4, told=False).state != "blind"
    estimate = sound.run(0.3, told=False)
    assert estimate.state == "blind"
    assert estimate.rate_bps == STARTING_RATE_BPS
    assert sound.run(0.1).state == "steady"


def test_who_sends_nothing_is_not_blind() -> None:
    """Feedback is overdue only if something was sent that could be answered."""
    sound = Sound()
    sound.run(5.0)
    assert sound.estimator.estimate(sound.now_s + 60).state == "steady"


def test_who_is_not_told_of_what_is_sent_is_not_blind() -> None:
    """A stream without feedback is no reason to wait for feedback."""
    sound = Sound()
    sound.run(5.0)
    for tick in range(500):
        sound.estimator.sent(140, sound.now_s + tick / 50, has_feedback=False)
        assert sound.estimator.estimate(sound.now_s + tick / 50).state == "steady"


def test_a_queue_that_nobody_tells_of_any_more_is_none() -> None:
    """Congestion ends 3 s after the last packet that feedback could have reported."""
    sound = Sound()
    sound.run(5.0)
    assert sound.run(0.5, late_s=lambda at_s: at_s).state == "congested"
    assert sound.estimator.estimate(sound.now_s + 3.1).state == "steady"


def test_long_round_trips_blind_nobody() -> None:
    """With round trips of a second, feedback may take two."""
    sound = Sound()
    sound.run(5.0)
    sound.estimator.round_trip(1.0, sound.now_s)
    assert sound.run(1.9, told=False).state != "blind"
    assert sound.estimator.estimate(sound.now_s).round_trip_ms == 1000
    assert sound.run(0.3, told=False).state == "blind"


def test_after_a_long_silence_it_begins_carefully() -> None:
    """After ten silent seconds the earlier rate of a fast link is not used."""
    estimator = LinkEstimator()
    now_s = _climb(estimator)
    assert estimator.estimate(now_s).rate_bps > 2e6
    estimator.sent(100, now_s)
    now_s += 10
    estimator.delivered([Delivery(now_s - 0.1, 5.0, 100, "audio")], now_s)
    estimate = estimator.estimate(now_s)
    assert estimate.rate_bps == STARTING_RATE_BPS
    assert estimate.state == "starting"


def _climb(estimator: LinkEstimator, *, ends_alone: bool = False) -> float:
    """Send pictures over a perfect link until the rate is known to be high.

    With `ends_alone` feedback reports only the first and the last packet of each picture, and a
    picture is left out after each.
    """
    now_s = 1.0
    for _ in range(20):
        train = estimator.plan_train(4000, now_s)
        deliveries = []
        for _ in range(math.ceil(4000 / train.payload_bytes)):
            size = train.payload_bytes + 60
            estimator.sent(size, now_s)
            deliveries.append(Delivery(now_s, now_s + 7, size, "video", train.number))
            now_s += size * 8 / train.pace_bps
        now_s += 0.05
        if ends_alone:
            estimator.plan_train(10, now_s)
            deliveries = [deliveries[0], deliveries[-1]]
        estimator.delivered(deliveries, now_s)
    return now_s


def test_a_stream_that_joins_changes_no_estimate() -> None:
    """A camera that starts later, or sound without feedback, changes nothing known of the link."""
    estimator = LinkEstimator()
    estimator.negotiated(has_feedback=True, kind="video")
    now_s = _climb(estimator)
    before = estimator.estimate(now_s)
    estimator.negotiated(has_feedback=True, kind="video")
    estimator.negotiated(has_feedback=False, kind="audio")
    assert estimator.estimate(now_s) == before


def test_marks_on_a_few_packets_cost_no_rate() -> None:
    """If feedback reports only the ends of a train, the packets between them count all the same."""
    estimator = LinkEstimator()
    now_s = _climb(estimator, ends_alone=True)
    assert estimator.estimate(now_s).rate_bps > 1e6


def test_a_lost_feedback_at_the_start_is_no_error() -> None:
    """A slow train lowers the rate, even if nothing is reported of the next one."""
    estimator, now_s, told = LinkEstimator(), 1.0, []
    for picture in range(3):
        train = estimator.plan_train(4000, now_s)
        for packet in range(3):
            estimator.sent(900, now_s)
            if picture != 1:
                arrived_s = 7 + picture + packet / 10
                told.append(Delivery(now_s, arrived_s, 900, "video", train.number))
            now_s += 0.01
    estimator.delivered(told, now_s)
    assert estimator.estimate(now_s).rate_bps < STARTING_RATE_BPS


@given(st.integers(1, 200_000), st.floats(0, 100))
def test_a_picture_never_delays_sound_for_long(size_bytes: int, now_s: float) -> None:
    """If the link carries just the rate, a picture's pace queues 50 ms at most."""
    estimator = LinkEstimator()
    rate_bps = estimator.estimate(now_s).rate_bps
    train = estimator.plan_train(size_bytes, now_s)
    assert train.pace_bps >= rate_bps
    assert size_bytes * 8 / rate_bps - size_bytes * 8 / train.pace_bps <= 0.050 + 1e-9
    assert 200 <= train.payload_bytes <= 1180


def test_trains_are_numbered() -> None:
    """Every picture has a number of its own, which rises."""
    estimator = LinkEstimator()
    numbers = [estimator.plan_train(1000, 1.0).number for _ in range(5)]
    assert numbers == sorted(set(numbers))


def test_fruitless_probes_become_rare() -> None:
    """On a line that carries no more, large probes back off to one in 16 s or less often."""
    estimator = LinkEstimator()
    carried_bps, free_s = 60_000.0, 0.0
    probes = []
    now_s = 1.0
    while now_s < 90:
        train = estimator.plan_train(1500, now_s)
        if train.pace_bps > 1.3 * estimator.estimate(now_s).rate_bps:
            probes.append(now_s)
        deliveries = []
        sent_s = now_s
        for _ in range(math.ceil(1500 / train.payload_bytes)):
            size = train.payload_bytes + 60
            estimator.sent(size, sent_s)
            free_s = max(free_s, sent_s) + size * 8 / carried_bps
            deliveries.append(Delivery(sent_s, free_s + 0.02, size, "video", train.number))
            sent_s += size * 8 / train.pace_bps
        now_s += 0.5
        estimator.delivered(deliveries, now_s)
    assert probes
    assert len([probe_s for probe_s in probes if probe_s > 40]) <= 4


weird = st.floats() | st.floats(-1, 200)
deliveries = st.builds(
    Delivery,
    sent_s=weird,
    arrived_s=st.none() | weird,
    size_bytes=st.integers(-10, 100_000),
    kind=st.sampled_from(["audio", "video", "repeat"]),
    train=st.none() | st.integers(-5, 50),
)
moves = st.one_of(
    st.tuples(st.just("sent"), st.integers(-10, 100_000), weird),
    st.tuples(st.just("told"), st.lists(deliveries, max_size=12), weird),
    st.tuples(st.just("trip"), weird, weird),
    st.tuples(st.just("report"), weird, weird),
    st.tuples(st.just("train"), st.integers(-10, 10**7), weird),
)


@examples(150)
@given(st.lists(moves, max_size=40), st.booleans())
def test_lies_are_bounded(trace: list[tuple[str, object, float]], sound_has_feedback: bool) -> None:
    """Whatever is reported, and however time runs, nothing is raised and all is within bounds."""
    estimator = LinkEstimator()
    estimator.negotiated(has_feedback=True, kind="video")
    estimator.negotiated(has_feedback=sound_has_feedback, kind="audio")
    for kind, what, now_s in trace:
        if kind == "sent":
            estimator.sent(what, now_s)  # type: ignore[arg-type]
        elif kind == "told":
            estimator.delivered(what, now_s)  # type: ignore[arg-type]
        elif kind == "report":
            estimator.reported(what, now_s, "audio")  # type: ignore[arg-type]
        elif kind == "trip":
            estimator.round_trip(what, now_s)  # type: ignore[arg-type]
        else:
            train = estimator.plan_train(what, now_s)  # type: ignore[arg-type]
            assert 200 <= train.payload_bytes <= 1180
            assert 8_000 <= train.pace_bps <= 2e8
        estimate = estimator.estimate(now_s)
        assert 8_000 <= estimate.rate_bps <= 20e6
        assert 0 <= estimate.queue_ms <= 10_000
        assert 0 <= estimate.jitter_ms <= 10_000
        assert 0 <= estimate.lost <= 1
        assert estimate.burst >= 0
        assert math.isfinite(estimate.used_bps)
        assert estimate.round_trip_ms is None or 0 <= estimate.round_trip_ms <= 10_000


def test_whoever_loses_everything_costs_no_memory() -> None:
    """Endless feedback that nothing arrives takes as much memory after 200 s as after 100."""
    estimator, sizes = LinkEstimator(), []
    for number in range(20_000):
        now_s = number / 100
        estimator.sent(1000, now_s)
        estimator.delivered([Delivery(now_s, None, 1000, "video", None)], now_s)
        if number % 10_000 == 9_999:
            sizes.append(len(pickle.dumps(estimator)))
    assert sizes[1] <= 1.05 * sizes[0]
