"""The allocator alone: it picks the best that fits, changes rarely, and never less if faster."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import replace
from itertools import pairwise
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from tests.examples import examples
from tests.sync.link_model import default_sounds, default_steps

from wax.congestion.allocation import Allocation, SoundEncoding, Step, area
from wax.congestion.allocator import Allocator
from wax.congestion.control import LinkEstimate, LinkState
from wax.congestion.wire_cost import picture_bps, sound_bps
from wax.sentence import Sentence

STEPS, SOUNDS = default_steps(), default_sounds()
STEADY = LinkEstimate("steady", 5e6, 1e6, 0.0, 5.0, 0.0, 0, 40.0)


class Viewer:
    """Asks ten times a second."""

    def __init__(self, ladder: Allocator | None = None) -> None:
        self.ladder = ladder or Allocator(STEPS, SOUNDS)
        self.now_s = 100.0
        self.size: str | None = "640x480"
        self.sound = True
        self.encoding: SoundEncoding | None = None
        self.channels = 1
        self.takes_redundancy = True

    def decide(self, estimate: LinkEstimate) -> Allocation:
        return self.ladder.decide(
            estimate,
            size=self.size,
            sound=self.sound,
            sound_encodings=None if self.encoding is None else [self.encoding],
            sound_channels=self.channels,
            other_bps=4000,
            now_s=self.now_s,
            takes_redundancy=self.takes_redundancy,
        )

    def run(self, seconds: float, rate_bps: float, **other: object) -> list[Allocation]:
        out = []
        for _ in range(round(seconds * 10)):
            out.append(self.decide(replace(STEADY, rate_bps=rate_bps, **other)))  # type: ignore[arg-type]
            self.now_s += 0.1
        return out


def _takes_bps(allocation: Allocation, rate_bps: float) -> float:
    takes = sound_bps(allocation.sound, allocation.redundancy) if allocation.sound else 0.0
    if allocation.step is not None:
        takes += picture_bps(
            allocation.step, allocation.step.layers - allocation.top_layer, rate_bps
        )
    return takes


def _worth(allocation: Allocation) -> tuple[int, int, int]:
    """Order allocations: picture by step and layers; sound by encoding."""
    step = -1 if allocation.step is None else len(STEPS) - STEPS.index(allocation.step)
    assert allocation.sound is not None
    return step, allocation.top_layer if allocation.step else 0, -SOUNDS.index(allocation.sound)


def test_it_begins_small_while_nothing_is_known() -> None:
    """While the rate is only assumed, the smallest step is sent."""
    viewer = Viewer()
    allocation = viewer.run(0.3, 300_000, state="starting", assumed=True)[-1]
    assert allocation.step == STEPS[-1]
    assert allocation.reason == Sentence("sent.starting")
    allocation = viewer.run(0.1, 1.5e6, state="starting")[-1]
    assert allocation.step == STEPS[0]


@pytest.mark.parametrize(
    ("rate_bps", "name"),
    [
        (2e6, "640x480 at 1000 kbit/s"),
        (950e3, "640x480 at 600 kbit/s"),
        (500e3, "320x240 at 300 kbit/s"),
        (300e3, "320x240 at 120 kbit/s"),
        (120e3, "160x120 at 50 kbit/s"),
        (60e3, "160x120 at 16 kbit/s"),
    ],
)
def test_each_rate_has_its_step(rate_bps: float, name: str) -> None:
    """The best step is sent that fits, with all layers, into 85 % of the rate after the sound."""
    allocation = Viewer().run(20, rate_bps)[-1]
    assert allocation.step is not None
    assert allocation.step.name == name
    assert allocation.top_layer == allocation.step.layers


@examples(60)
@given(st.floats(60e3, 5e6))
def test_what_is_chosen_fits(rate_bps: float) -> None:
    """Sound and picture together take no more than the rate that was left."""
    allocation = Viewer().run(20, rate_bps)[-1]
    assert _takes_bps(allocation, rate_bps) + 4000 <= 1.1 * rate_bps
    if allocation.step != STEPS[-1]:
        assert _takes_bps(allocation, rate_bps) + 4000 <= 0.95 * rate_bps


states = st.sampled_from(["starting", "steady", "congested", "blind"])
traces = st.lists(
    st.tuples(st.floats(8e3, 3e6), states, st.sampled_from([0.0, 0.02, 0.1]), st.floats(0.1, 8)),
    max_size=12,
)


@examples(200)
@given(traces, st.floats(8e3, 3e6), st.floats(1, 3), states, st.sampled_from([0.0, 0.02, 0.1]))
def test_more_never_gives_less(
    trace: list[tuple[float, LinkState, float, float]],
    rate_bps: float,
    factor: float,
    state: LinkState,
    lost: float,
) -> None:
    """From the same past a higher rate never gives a smaller picture or poorer sound."""
    viewer = Viewer()
    for past_bps, past_state, past_lost, pause_s in trace:
        viewer.decide(replace(STEADY, rate_bps=past_bps, state=past_state, lost=past_lost, burst=2))
        viewer.now_s += pause_s
    other = deepcopy(viewer)
    estimate = replace(STEADY, rate_bps=rate_bps, state=state, lost=lost, burst=2)
    less = _worth(viewer.decide(estimate))
    more = _worth(other.decide(replace(estimate, rate_bps=rate_bps * factor)))
    assert more[:2] >= less[:2]
    assert more[2] >= less[2]


@examples(80)
@given(st.floats(20e3, 3e6), st.lists(st.floats(0.93, 1.07), min_size=50, max_size=50))
@example(29_237.0, [*[1.0] * 43, 0.9375, *[1.0] * 6])
def test_a_steady_link_changes_no_step_twice_in_5_s(rate_bps: float, noise: list[float]) -> None:
    """An estimate that varies by 7 % never causes two changes of step within 5 s."""
    viewer = Viewer()
    viewer.run(3.5, rate_bps)
    changes, step = [], viewer.run(0.1, rate_bps)[-1].step
    for factor in noise:
        began_s = viewer.now_s
        for look, allocation in enumerate(viewer.run(0.8, rate_bps * factor)):
            if allocation.step != step:
                changes.append(began_s + look / 10)
                step = allocation.step
    assert all(later - earlier >= 4.99 for earlier, later in pairwise(changes))


def test_less_is_sent_in_the_same_decision() -> None:
    """When the rate falls a little, the upper layer goes at once and the step follows."""
    viewer = Viewer()
    viewer.run(10, 2e6)
    allocation = viewer.run(0.1, 800e3)[-1]
    assert allocation.step == STEPS[0]
    assert allocation.top_layer == 1
    allocation = viewer.run(2, 800e3)[-1]
    assert allocation.step == STEPS[2]
    assert str(allocation.reason) == "the link carries about 800 kbit/s"


def test_a_step_of_which_nothing_fits_is_left_at_once() -> None:
    """If not even a step's lowest layer fits, the next decision changes the step."""
    viewer = Viewer()
    viewer.run(10, 2e6)
    assert viewer.run(0.1, 270e3)[-1].step == STEPS[3]


def test_no_keyframe_is_asked_for_into_a_full_queue() -> None:
    """While the queue is long only the lowest layer is sent; then the new step begins."""
    viewer = Viewer()
    viewer.run(10, 2e6)
    allocation = viewer.run(1.0, 270e3, state="congested", queue_ms=400.0)[-1]
    assert allocation.step == STEPS[0]
    assert allocation.top_layer == 0
    assert viewer.run(0.1, 270e3, state="congested", queue_ms=50.0)[-1].step == STEPS[3]


def test_it_goes_up_after_a_while_and_skips_steps() -> None:
    """A higher rate counts after a second, and then the best step that fits is chosen."""
    viewer = Viewer()
    viewer.run(10, 270e3)
    assert viewer.run(0.9, 2e6)[-1].step == STEPS[3]
    steps = [allocation.step for allocation in viewer.run(1.0, 2e6)]
    assert set(steps) <= {STEPS[3], STEPS[0]}
    assert steps[-1] == STEPS[0]


def test_a_larger_wish_is_met_at_once_unless_the_link_was_the_limit() -> None:
    """A picture that was small by the viewer's wish grows with the wish; others wait as ever."""
    viewer = Viewer()
    viewer.size = "320x240"
    for rate_bps, small, large in ((2e6, STEPS[2], STEPS[0]), (270e3, STEPS[3], STEPS[3])):
        assert viewer.run(10, rate_bps)[-1].step == small
        viewer.size = "640x480"
        assert viewer.run(0.1, 2e6)[-1].step == large
        viewer.size = "320x240"


@given(st.lists(st.sampled_from(["640x480", "320x240", "160x120", None]), min_size=60, max_size=60))
@example(["640x480", "160x120"] * 30)
@example(["640x480", None] * 30)
@examples(50)
def test_wishes_that_change_all_the_time_raise_the_picture_a_few_times_a_minute(
    wishes: list[str | None],
) -> None:
    """Whatever is wished each second, the picture shrinks at once, and grows 19 times a minute."""
    viewer = Viewer()
    viewer.run(10, 5e6)
    grown, least_bps = 0, STEPS[-1].bitrate_bps
    before_bps = STEPS[0].bitrate_bps
    for wish in wishes:
        viewer.size = wish
        for allocation in viewer.run(1.0, 5e6):
            step, is_wanted = allocation.step, wish is not None
            assert step is None or (is_wanted and area(step.size) <= area(wish or ""))
            rate_bps = least_bps if step is None else step.bitrate_bps
            grown, before_bps = grown + (rate_bps > before_bps), rate_bps
    assert grown <= 4 + 60 / 20 + 60 / 5


def test_a_rise_that_failed_is_tried_later_each_time() -> None:
    """Each failed upgrade makes the next one wait longer."""
    viewer = Viewer()
    viewer.run(10, 270e3)
    waits = []
    for _ in range(4):
        begun_s = viewer.now_s
        while viewer.run(0.1, 1e6)[-1].step != STEPS[1]:
            assert viewer.now_s - begun_s < 100
        waits.append(viewer.now_s - begun_s)
        viewer.run(2, 1e6)
        viewer.run(10, 270e3, state="congested")
    assert waits == sorted(waits)
    assert waits[-1] >= 3 * waits[1]


def test_nothing_goes_up_while_the_link_is_not_calm() -> None:
    """On a congested or blind link nothing is upgraded."""
    for state in ("congested", "blind"):
        viewer = Viewer()
        viewer.run(10, 270e3)
        assert viewer.run(10, 2e6, state=state)[-1].step == STEPS[3]
    assert viewer.run(0.1, 2e6, state="blind")[-1].reason == Sentence("sent.blind")


def test_sound_outlives_the_picture() -> None:
    """If only sound fits the picture is dropped; it is tried again, and returns when it fits."""
    viewer = Viewer()
    viewer.run(5, 60e3)
    waits = viewer.run(4, 15e3)
    assert {(one.step, one.top_layer, one.sound) for one in waits} == {(STEPS[-1], 0, SOUNDS[-1])}
    allocations = viewer.run(60, 15e3)
    assert allocations[1].step is None
    assert allocations[1].sound == SOUNDS[-1]
    assert str(allocations[1].reason) == "the link carries about 15 kbit/s, enough for sound alone"
    trials = [allocation for allocation in allocations if allocation.step is not None]
    assert 0 < len(trials) < 200
    assert {(allocation.step, allocation.top_layer) for allocation in trials} == {(STEPS[-1], 0)}
    allocation = viewer.run(10, 60e3)[-1]
    assert allocation.step == STEPS[-1]
    assert allocation.top_layer == STEPS[-1].layers


def test_a_picture_now_and_then_is_kept() -> None:
    """If the lowest layer nearly fits it is kept, and the pacer drops single pictures."""
    viewer = Viewer()
    viewer.run(5, 60e3)
    sound, least = SOUNDS[-1], STEPS[-1]
    fits_bps = (sound_bps(sound, 0) + 4000 + picture_bps(least, least.layers, 20e3)) / 1.1
    seldom = viewer.run(60, fits_bps - 1000)
    assert {(one.step, one.top_layer, one.tries) for one in seldom[5:]} == {(least, 0, False)}


def test_a_try_asks_for_no_more_than_the_lowest_layer() -> None:
    """A trial sends only the lowest layer, whatever rate it assumes."""
    viewer = Viewer()
    viewer.run(5, 60e3)
    while not viewer.run(0.1, 15e3)[0].tries:
        assert viewer.now_s < 200
    tried = viewer.run(4, 60e3)
    assert {(one.step, one.top_layer, one.tries) for one in tried} == {(STEPS[-1], 0, True)}


@pytest.mark.parametrize(
    ("rate_bps", "mu_ms"),
    [(26e3, 120), (45e3, 60), (100e3, 60), (140e3, 40), (250e3, 20), (5e6, 20)],
)
def test_the_sound_leaves_two_thirds_to_the_picture(rate_bps: float, mu_ms: int) -> None:
    """The best sound that takes a third at most; units above 60 ms only where no picture fits."""
    allocation = Viewer().run(10, rate_bps)[-1]
    assert allocation.sound is not None
    assert allocation.sound.mu_ms == mu_ms


@pytest.mark.parametrize(("rate_bps", "mu_ms"), [(60e3, 60), (250e3, 20), (5e6, 10)])
def test_shorter_units_are_sent_where_they_may_be(rate_bps: float, mu_ms: int) -> None:
    """A role that allows units of 10 ms gets them on a link with room for twice the headers."""
    allocator = Allocator(STEPS, [SoundEncoding(10, 32_000), *SOUNDS])
    allocation = Viewer(allocator).run(10, rate_bps)[-1]
    assert allocation.sound is not None
    assert allocation.sound.mu_ms == mu_ms


@pytest.mark.parametrize(
    ("rate_bps", "encoding"),
    [(45e3, (60, 1)), (140e3, (40, 1)), (200e3, (40, 2)), (250e3, (20, 1)), (5e6, (20, 2))],
)
def test_a_link_with_room_carries_two_channels(rate_bps: float, encoding: tuple[int, int]) -> None:
    """Stereo where it fits, preferably with shorter packets, and mono on a thin link."""
    stereo = [SoundEncoding(20, 56_000, 2), SOUNDS[0], SoundEncoding(40, 40_000, 2), *SOUNDS[1:]]
    viewer = Viewer(Allocator(STEPS, stereo))
    viewer.channels = 2
    sound = viewer.run(10, rate_bps)[-1].sound
    assert sound is not None
    assert (sound.mu_ms, sound.channels) == encoding
    viewer.channels = 1
    sound = viewer.run(10, rate_bps)[-1].sound
    assert sound is not None
    assert sound.channels == 1


def test_sound_alone_may_take_everything() -> None:
    """Without a picture the best encoding that fits at all is sent."""
    viewer = Viewer()
    viewer.size = None
    allocation = viewer.run(10, 80e3)[-1]
    assert allocation.step is None
    assert allocation.sound == SOUNDS[0]
    assert allocation.reason == Sentence("sent.no_picture")


def test_an_encoding_that_is_fixed_stays() -> None:
    """The configuration's encoding is used on any link."""
    viewer = Viewer()
    viewer.encoding = SOUNDS[0]
    assert {allocation.sound for allocation in viewer.run(5, 45e3)} == {SOUNDS[0]}


def test_without_sound_the_picture_has_it_all() -> None:
    """A viewer without sound is sent none, and a larger picture if that makes room for one."""
    viewer = Viewer()
    viewer.sound = False
    allocation = viewer.run(10, 770e3)[-1]
    assert allocation.sound is None
    assert allocation.step == STEPS[1]
    assert Viewer().run(10, 770e3)[-1].step == STEPS[2]


@pytest.mark.parametrize(
    ("lost", "burst", "redundancy"), [(0.004, 2, 0), (0.01, 1, 1), (0.05, 2, 2), (0.2, 9, 3)]
)
def test_loss_is_answered_by_sending_sound_again(lost: float, burst: int, redundancy: int) -> None:
    """From 0.5 % loss on, each packet repeats as many earlier units as are lost in a row."""
    assert Viewer().run(1, 5e6, lost=lost, burst=burst)[-1].redundancy == redundancy


def test_sound_is_not_sent_again_where_that_costs_the_picture() -> None:
    """On a modem line loss changes nothing: the sound already takes its third."""
    allocation = Viewer().run(10, 50e3, lost=0.05, burst=2)[-1]
    assert allocation.redundancy == 0
    assert allocation.step == STEPS[-1]


def test_a_browser_without_redundancy_gets_none() -> None:
    """A browser without support for redundancy gets none, whatever the loss."""
    viewer = Viewer()
    viewer.takes_redundancy = False
    assert viewer.run(1, 5e6, lost=0.2, burst=3)[-1].redundancy == 0


def test_redundancy_stays_a_while() -> None:
    """After the last loss, sound is repeated for 10 s more."""
    viewer = Viewer()
    viewer.run(5, 5e6, lost=0.05, burst=2)
    allocations = viewer.run(12, 5e6)
    assert allocations[95].redundancy == 2
    assert allocations[-1].redundancy == 0


def test_a_smaller_picture_is_given_where_asked_for() -> None:
    """A viewer who requests 320×240 gets its best step at once and none above, with a reason."""
    viewer = Viewer()
    viewer.run(10, 5e6)
    viewer.size = "320x240"
    allocation = viewer.run(0.1, 5e6)[-1]
    assert allocation.step == STEPS[2]
    assert allocation.reason == Sentence("sent.all")
    viewer.size = "100x80"  # smaller than any
    step = viewer.run(0.1, 5e6)[-1].step
    assert step is not None
    assert step.size == "160x120"


def test_steps_without_layers_are_changed_whole() -> None:
    """H.264 has no layers to drop, so a falling rate changes the step in the same decision."""
    viewer = Viewer(Allocator([replace(step, layers=0) for step in STEPS], SOUNDS))
    viewer.run(10, 2e6)
    allocation = viewer.run(0.1, 950e3)[-1]
    assert allocation.step is not None
    assert allocation.step.name == STEPS[1].name
    assert allocation.top_layer == 0


def test_a_link_that_is_no_worse_is_decided_on_seldom() -> None:
    """A decision can wait on a link that is as good as before, but never for long."""
    viewer = Viewer()
    assert not viewer.ladder.may_rest(STEADY, 4000, viewer.now_s)
    viewer.decide(STEADY)
    for better in (STEADY, replace(STEADY, rate_bps=20e6), replace(STEADY, queue_ms=60.0)):
        assert viewer.ladder.may_rest(better, 4000, viewer.now_s + 0.25)
        assert not viewer.ladder.may_rest(better, 4000, viewer.now_s + 0.35)


@pytest.mark.parametrize(
    ("worse", "other_bps"),
    [
        ({"state": "congested"}, 4000),
        ({"state": "blind"}, 4000),
        ({"burst": 1}, 4000),
        ({"lost": 0.006}, 4000),
        ({"queue_ms": 150.0}, 4000),
        ({"rate_bps": 0.97 * STEADY.rate_bps}, 4000),
        ({}, 4000 + 0.03 * STEADY.rate_bps),
    ],
)
def test_what_makes_a_link_worse_is_decided_on_at_once(
    worse: dict[str, Any], other_bps: float
) -> None:
    """Loss, a queue, a lower rate, more of other traffic or silence wait for no decision."""
    viewer = Viewer()
    viewer.decide(STEADY)
    assert not viewer.ladder.may_rest(replace(STEADY, **worse), other_bps, viewer.now_s + 0.01)


def test_a_link_that_starts_is_decided_on_at_once() -> None:
    """While a link starts each estimate may allow more."""
    viewer = Viewer()
    starting = replace(STEADY, state="starting")
    viewer.decide(starting)
    assert not viewer.ladder.may_rest(starting, 4000, viewer.now_s + 0.01)


def test_a_ladder_needs_something_to_choose_from() -> None:
    """No step, no sound or an invalid size is refused with a message."""
    with pytest.raises(ValueError, match="at least one step"):
        Allocator([], SOUNDS)
    with pytest.raises(ValueError, match="at least one step"):
        Allocator(STEPS, [])
    with pytest.raises(ValueError, match="large is no size"):
        Allocator([Step("x", "large", 30.0, 100_000, 2)], SOUNDS)
