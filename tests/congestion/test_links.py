"""Estimator, pacer and ladder together, over the emulated links."""

from __future__ import annotations

from itertools import pairwise

import pytest
from tests.ablation.links import repeated_outages
from tests.examples import at_length
from tests.sync.link_model import Loop, Packet, default_steps, profile

from wax.sentence import Sentence

TOP, MIDDLE, *_, LEAST = default_steps()

cases = pytest.mark.parametrize(
    ("feedback_s", "seed"), [(0.1, 2), *at_length((0.05, 1), (0.25, 3), (0.1, 4))]
)


@cases
def test_on_one_machine_the_top_is_reached_at_once(feedback_s: float, seed: int) -> None:
    """An unlimited link carries the best within a second, with at most three keyframes."""
    record = Loop(profile("same-machine"), feedback_s=feedback_s, seed=seed).run(5)
    changes = record.changes()
    assert changes[0][1] == LEAST
    assert changes[-1] == (changes[-1][0], TOP)
    assert changes[-1][0] < 1.0
    assert len(changes) <= 4
    assert record.allocations[-1][1].reason == Sentence("sent.all")


@cases
def test_a_modem_line_is_not_filled(feedback_s: float, seed: int) -> None:
    """After 8 s no queue exceeds 150 ms, no sound is 100 ms late, and 5 pictures/s arrive."""
    network = profile("modem-56k")
    record = Loop(network, feedback_s=feedback_s, seed=seed).run(30)
    assert all(estimate.queue_ms <= 150 for at_s, estimate in record.estimates if at_s > 8)
    own_ms = 60 + 24  # the route's delay, and the length of a packet of sound
    assert record.sound_ms(8, 30, 1.0) <= own_ms + 100
    assert record.picture_ms(8, 30, 0.95) <= 300
    assert record.fps(8, 30) >= 5
    assert record.lost_sounds == 0


class _Busy(Loop):
    """An operator's link: beats, sender reports and messages take 30 % of it."""

    def _ping(self) -> None:
        tick = round((self.now_s - self.start_s) / 0.1)
        sizes = [113] * (tick % 2 == 0) + [118] * (tick % 5 == 0) + [430] * (tick % 50 == 49)
        for size in sizes:
            self._send(Packet(self.now_s, size, "ping"))
        self._at(self.now_s + 0.1, self._ping)


@pytest.mark.parametrize(("viewer", "most"), [(Loop, 0.01), (_Busy, 0.02)])
def test_the_slowest_modem_carries_sound_and_pictures(viewer: type[Loop], most: float) -> None:
    """On 28.8 kbit/s no picture takes 4 s, and hardly any sound is concealed.

    For an operator that is one packet of 120 ms now and then.
    """
    record = viewer(profile("modem-28k"), drives=viewer is _Busy).run(100)
    played = [row for row in record.played if row[0] >= 10]
    concealed_s, played_s = (played[-1][n] - played[0][n] for n in (1, 2))
    assert concealed_s <= most * played_s
    shown_s = [10.0, *(at_s for at_s, _ in record.shown if at_s > 10), 100.0]
    assert max(later - one for one, later in pairwise(shown_s)) < 4


@cases
def test_stalls_are_no_congestion(feedback_s: float, seed: int) -> None:
    """On 5 Mbit/s with a stall every 2.5 s the best is reached soon and then kept."""
    record = Loop(profile("internet-5m"), feedback_s=feedback_s, seed=seed).run(15)
    assert record.changes(5.0) == [(record.changes(5.0)[0][0], TOP)]
    assert all(estimate.rate_bps > 1.5e6 for at_s, estimate in record.estimates if at_s > 8)
    assert record.sound_ms(5, 15, 0.95) <= 100
    assert record.picture_ms(5, 15, 0.95) <= 100


@cases
def test_a_wireless_megabit_settles(feedback_s: float, seed: int) -> None:
    """1 Mbit/s with jitter and stalls settles on 640×480 at 600 kbit/s and stays there."""
    record = Loop(profile("wireless-1m"), feedback_s=feedback_s, seed=seed).run(25)
    assert [step for _, step in record.changes(10.0)] == [MIDDLE]
    assert record.fps(10, 25) >= 25
    assert record.picture_ms(10, 25, 0.95) <= 100


@cases
def test_a_fall_of_the_rate_is_answered(feedback_s: float, seed: int) -> None:
    """5 Mbit/s, 300 kbit/s, and 5 again: pictures are fresh after 2 s, and full 15 s later."""
    record = Loop(profile("step-down"), feedback_s=feedback_s, seed=seed).run(26)
    fell_s, rose_s = 5.0, 10.0
    answered = [
        at_s
        for at_s, estimate in record.estimates
        if at_s > fell_s and estimate.rate_bps <= 300_000
    ]
    assert answered[0] - fell_s <= 0.3 + 2 * feedback_s
    assert record.picture_ms(fell_s + 2, rose_s, 1.0) <= 300
    assert record.sound_ms(fell_s + 2, rose_s, 1.0) <= 150
    top_s = next(at_s for at_s, step in record.changes(rose_s) if step == TOP and at_s > rose_s)
    assert top_s - rose_s <= 15
    assert record.changes()[-1][1] == TOP


def test_a_fall_is_noticed_by_samples() -> None:
    """A settled observer's browser reports only samples, which show 300 kbit/s within 1.5 s."""
    record = Loop(profile("step-down"), feedback_s=0.05, drives=False).run(7)
    assert record.at(5.0).step == TOP
    fell_s = next(at for at, one in record.estimates if at > 5 and one.rate_bps <= 300_000)
    assert fell_s - 5 <= 1.5


@cases
def test_random_loss_costs_no_quality(feedback_s: float, seed: int) -> None:
    """5 % lost in bursts keep the best picture, and sound is repeated often enough."""
    record = Loop(profile("wifi-bad"), feedback_s=feedback_s, seed=seed).run(12)
    assert [step for _, step in record.changes(5.0)] == [TOP]
    assert all(estimate.rate_bps > 1.5e6 for at_s, estimate in record.estimates if at_s > 5)
    assert all(allocation.redundancy >= 1 for at_s, allocation in record.allocations if at_s > 5)
    assert all(
        allocation.sound.mu_ms == 20 for _, allocation in record.allocations if allocation.sound
    )


@cases
def test_a_round_trip_of_600_ms_blinds_nobody(feedback_s: float, seed: int) -> None:
    """Over a satellite the best is reached in 5 s and kept, and the link is never silent."""
    record = Loop(profile("satellite"), feedback_s=feedback_s, seed=seed).run(12)
    assert [step for _, step in record.changes(5.0)] == [TOP]
    assert not [at_s for at_s, estimate in record.estimates if estimate.state == "blind"]
    assert record.picture_ms(5, 12, 0.95) <= 350


def test_an_outage_is_waited_out() -> None:
    """While no feedback comes, pictures pause; afterwards they are as fresh and good as before."""
    record = Loop(profile("outage")).run(14)
    assert {estimate.state for at_s, estimate in record.estimates if 5.8 < at_s < 7} == {"blind"}
    assert record.picture_ms(8, 14, 1.0) <= 100
    assert record.at(14).step == TOP


@pytest.mark.parametrize("seed", [1, *at_length(2, 3)])
def test_what_an_outage_loses_is_no_congestion(seed: int) -> None:
    """Two seconds of total loss cost no step of the ladder."""
    record = Loop(repeated_outages(), feedback_s=0.05, seed=seed).run(25)
    assert record.at(24.0).step == record.at(19.0).step


@pytest.mark.parametrize("queue_ms", [60, *at_length(150)])
def test_a_short_queue_is_not_overrun(queue_ms: float) -> None:
    """If the queue is shorter than a stall, trains and losses still show the rate."""
    record = Loop(profile("wireless-2m", rate_bps=400_000, queue_ms=queue_ms)).run(18)
    assert all(estimate.rate_bps <= 500_000 for at_s, estimate in record.estimates if at_s > 10)
    assert record.estimates[-1][1].lost < 0.05


@pytest.mark.parametrize(
    "name", ["isdn-64k", *at_length("lte-edge", "lte-good", "wireless-2m", "campus")]
)
def test_no_flapping(name: str) -> None:
    """On any steady link, once measured, at most one step changes in 5 s."""
    record = Loop(profile(name)).run(30)
    changes = [at_s for at_s, _ in record.changes(10.0)]
    assert all(later - earlier >= 5.0 for earlier, later in pairwise(changes))


def test_the_clocks_do_not_matter() -> None:
    """A browser's clock with any origin and a drift of 200 ppm leads to the same picture."""
    network = profile("internet-5m")
    for origin_s, drift in ((-1e9, 200e-6), (3e8, -200e-6)):
        record = Loop(network, origin_s=origin_s, drift=drift).run(8)
        assert [step for _, step in record.changes(5.0)] == [TOP]
