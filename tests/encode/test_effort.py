"""When the processor's encoder hurries, and what that costs."""

from __future__ import annotations

from itertools import count
from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.encode.encoders import SMALL, picture

from wax.encode.effort import Effort
from wax.encode.video_encoder import VideoEncoder

if TYPE_CHECKING:
    from typing import Literal

FPS = 30
SLOW_S, QUICK_S, HALF_S = 0.9 / FPS, 0.1 / FPS, 0.3 / FPS


def changes(effort: Effort, took_s: float, pictures: int, *, keyframe: bool = False) -> list[int]:
    """Take so many pictures; return the numbers of those before which the effort changed."""
    changed = []
    for number in range(pictures):
        if effort.changes(keyframe=keyframe):
            changed.append(number)
        effort.took(took_s)
    return changed


def hurried() -> Effort:
    """Return one that has begun to hurry with its next picture."""
    effort = Effort(FPS)
    while not effort.changes(keyframe=False):
        effort.took(SLOW_S)
    return effort


def test_slow_encoding_hurries_within_a_second_and_once() -> None:
    effort = Effort(FPS)
    changed = changes(effort, SLOW_S, 60)
    assert len(changed) == 1
    assert changed[0] <= FPS
    assert effort.is_hurried


def test_a_burst_of_other_work_changes_nothing() -> None:
    effort = Effort(FPS)
    assert changes(effort, SLOW_S, 10) == []
    assert changes(effort, QUICK_S, 300) == []


def test_sharpness_comes_back_with_a_keyframe_on_a_machine_that_stays_calm() -> None:
    effort = hurried()
    assert changes(effort, QUICK_S, 300, keyframe=True) == []
    assert changes(effort, QUICK_S, 300) == []
    assert effort.changes(keyframe=True)
    assert not effort.is_hurried


def test_a_machine_that_is_in_time_by_hurrying_goes_on_hurrying() -> None:
    effort = hurried()
    assert changes(effort, HALF_S, 3000, keyframe=True) == []


@given(st.lists(st.floats(0, 0.2), max_size=200))
def test_a_hurried_encoder_never_spends_a_keyframe_of_its_own(took_s: list[float]) -> None:
    effort = hurried()
    for one in took_s:
        assert not effort.changes(keyframe=False)
        effort.took(one)


@pytest.mark.parametrize("codec", ["vp8", "h264"])
def test_hurrying_begins_with_a_keyframe_in_the_same_size(codec: Literal["vp8", "h264"]) -> None:
    ticks = count()
    # Each look at the clock is most of a frame interval after the one before.
    encoder = VideoEncoder(codec=codec, rendition=SMALL, now_s=lambda: next(ticks) * SLOW_S)
    encoded = [encoder.encode(picture(number), keyframe=False) for number in range(60)]
    keyframes = [number for number, one in enumerate(encoded) if one and one.keyframe]
    assert len(keyframes) == 2
    assert keyframes[0] == 0
    assert keyframes[1] <= FPS
    assert all(encoded)
