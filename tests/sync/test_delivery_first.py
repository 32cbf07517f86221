"""On a link that cannot carry both, the live policies deliver first, and do not flap."""

from __future__ import annotations

import itertools

from hypothesis import given
from hypothesis import strategies as st

from wax.config.sync import SyncSettings
from wax.congestion.allocation import Allocation, SoundEncoding, Step
from wax.congestion.control import LinkEstimate, LinkState
from wax.sentence import says
from wax.sync.delivery_first import DeliveryFirst
from wax.sync.playout import PlayoutReport, PlayoutTargets, StreamPlayout
from wax.sync.policies import PlayoutPolicy, make_policy

STEP = Step("a", "640x480", 30.0, 1_000_000, 3)


def _estimate(state: LinkState) -> LinkEstimate:
    return LinkEstimate(state, 1e6, 5e5, 0.0, 3.0, 0.0, 0, 50.0)


def _allocation(step: Step | None) -> Allocation:
    return Allocation(step, 2, SoundEncoding(20, 32_000), 0, says(""))


class Viewer:
    """Reports the playout of both streams four times a second."""

    def __init__(self, settings: SyncSettings | None = None) -> None:
        self.policy: PlayoutPolicy = make_policy(settings or SyncSettings())
        self.ticks = 0
        self.concealed_ms = 0.0

    def watch(
        self,
        seconds: float,
        *,
        state: LinkState = "steady",
        step: Step | None = STEP,
        conceals_ms: float = 0.0,
        picture: bool = True,
    ) -> PlayoutTargets:
        for _ in range(int(seconds * 4)):
            self.ticks += 1
            self.concealed_ms += conceals_ms
            played = StreamPlayout(
                age_ms=150.0,
                delay_ms=60.0,
                concealed_ms=self.concealed_ms,
                played_ms=self.ticks * 250.0,
            )
            seen = StreamPlayout(age_ms=60.0, delay_ms=10.0) if picture else None
            targets = self.policy.decide(
                PlayoutReport(played, seen), self.ticks / 4, _estimate(state), _allocation(step)
            )
        return targets


def test_a_congested_link_plays_both_as_soon_as_possible() -> None:
    """After a second of congestion nothing is held back, the page says why, and it recovers."""
    viewer = Viewer()
    assert (viewer.watch(2.0).picture_ms or 0) > 0
    assert viewer.watch(1.0, state="congested").in_step
    targets = viewer.watch(0.5, state="congested")
    assert (targets.in_step, targets.picture_ms) == (False, 0.0)
    assert "congested" in str(targets.reason)
    assert not viewer.watch(3.75).in_step
    assert viewer.watch(0.5).in_step
    assert (viewer.watch(1.0).picture_ms or 0) > 0


def test_a_link_that_no_picture_fits_puts_delivery_first() -> None:
    """While no step of the ladder fits, delivery comes first for a viewer who wants a picture."""
    viewer = Viewer()
    assert not viewer.watch(2.0, step=None).in_step
    assert "no picture fits" in str(viewer.watch(1.0, step=None).reason)


def test_sound_that_breaks_however_long_it_waits_puts_delivery_first() -> None:
    """A longest delay that is no use is dropped until the sound is whole for a while."""
    viewer = Viewer()
    targets = viewer.watch(30.0, conceals_ms=200.0)
    assert (targets.in_step, targets.sound_ms, targets.picture_ms) == (False, None, 0.0)
    assert not viewer.watch(10.0, conceals_ms=200.0).in_step
    assert viewer.watch(8.0).in_step


def test_who_wants_one_stream_has_nothing_to_synchronise() -> None:
    """With the picture off, sound and picture are never out of step (thesis 3.3)."""
    viewer = Viewer()
    viewer.watch(2.0, state="congested")
    assert viewer.watch(0.25, state="congested", picture=False).in_step


def test_video_first_holds_nothing_back_but_finds_the_sounds_delay() -> None:
    """With `video-first` neither stream waits, and the sound still does not break."""
    viewer = Viewer(SyncSettings(policy="video-first"))
    targets = viewer.watch(5.0, conceals_ms=30.0)
    assert targets.picture_ms == 0.0
    assert (targets.sound_ms or 0) > 50


@given(st.lists(st.booleans(), max_size=200))
def test_it_is_entered_and_left_with_hysteresis(troubles: list[bool]) -> None:
    """It begins only after a second with a constant reason, and ends after four without one."""
    mode = DeliveryFirst()
    active = []
    for tick, trouble in enumerate(troubles):
        mode.update(says("trouble") if trouble else None, tick / 4)
        active.append(mode.is_active)
    for index, (before, now) in enumerate(itertools.pairwise(active), start=1):
        if now and not before:
            assert all(troubles[index - 4 : index + 1])
        if before and not now:
            assert not any(troubles[index - 16 : index + 1])
