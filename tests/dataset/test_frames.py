"""What a frame of an episode holds."""

from __future__ import annotations

import math
from bisect import bisect_right
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from tests.dataset.driven_tape import commanded, reported, steered

from wax.dataset.frames import HELD_BACK, PASSED, SLOWED, DatasetFrame, Grid, Timeline

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.protocol.tape_events import TapeEvent


def sampled(times_s: Sequence[float], fps: float) -> list[float]:
    """Return the capture time of each frame's picture."""
    grid: Grid[float] = Grid(fps)
    frames = [one for at_s in times_s for one in grid.add(at_s, at_s)]
    frames += grid.finish()
    assert all(captured_s == picture for captured_s, picture in frames)
    return [captured_s for captured_s, _ in frames]


def test_pictures_at_the_rate_are_taken_as_they_are() -> None:
    """Jitter below half a frame neither repeats nor skips a picture."""
    times_s = [n / 30 + 0.015 * math.sin(n) for n in range(300)]
    assert sampled(times_s, 30) == times_s


def test_a_missing_picture_is_the_one_before_it() -> None:
    """A frame without a picture of its own repeats the last, and its time says so."""
    assert sampled([0.0, 0.1, 0.4, 0.5], 10) == [0.0, 0.1, 0.1, 0.1, 0.4, 0.5]


def test_a_lower_rate_takes_the_nearest_picture() -> None:
    """Of thirty a second ten are taken, each at most half a picture's time from its frame."""
    taken = sampled([n / 30 + 0.01 for n in range(31)], 10)
    assert taken == pytest.approx([0.01 + n / 10 for n in range(11)])


@example([0.25], 10)
@given(
    st.lists(st.floats(0.001, 0.4), min_size=1, max_size=60), st.sampled_from([5, 10, 24, 30, 60])
)
def test_each_frame_is_the_nearest_picture_that_is_not_late(gaps_s: list[float], fps: int) -> None:
    """A frame's picture is nearest to it, unless that comes half a frame late; none goes back."""
    times_s = [sum(gaps_s[:n]) for n in range(len(gaps_s) + 1)]
    frames = sampled(times_s, fps)
    assert frames == sorted(frames)
    assert len(frames) >= math.floor((times_s[-1] - times_s[0]) * fps)
    rounded_s = 1e-9
    for number, captured_s in enumerate(frames):
        due_s = times_s[0] + number / fps
        fit = [at_s for at_s in times_s if at_s <= due_s + 0.5 / fps - rounded_s]
        best_s = min(abs(at_s - due_s) for at_s in fit)
        assert abs(captured_s - due_s) <= best_s + rounded_s


def frame(at_s: float, *events: tuple[float, TapeEvent]) -> DatasetFrame | None:
    timeline = Timeline(events, actions=("linear_mps", "angular_rps"), observed=("x_m",))
    return timeline.frame(at_s)


def test_the_action_is_the_set_point_in_force() -> None:
    """The last set-point at or before the capture counts, and the last report."""
    events: list[tuple[float, TapeEvent]] = [
        (1.0, steered(0.1)),
        (1.0, reported(7.0)),
        (2.0, steered(0.2, 0.3)),
        (2.5, reported(8.0)),
        (2.6, steered(0.4)),
    ]
    assert frame(2.5, *events) == DatasetFrame(2.5, (0.2, 0.3), (8.0,), PASSED, held=False)
    assert frame(2.0, *events) == DatasetFrame(2.0, (0.2, 0.3), (7.0,), PASSED, held=False)


def test_nothing_is_made_up_before_the_first_set_point_and_report() -> None:
    """There is no frame while the action or an observation is unknown."""
    assert frame(0.5, (1.0, steered(0.1)), (0.0, reported())) is None
    assert frame(1.5, (1.0, steered(0.1)), (1.6, reported())) is None
    assert frame(1.5, (1.0, steered(0.1)), (1.0, reported(None))) is None


def test_a_value_that_is_not_told_is_still_what_was_told_last() -> None:
    """A robot that loses a value for a while keeps the last one."""
    told = frame(3.0, (0.0, steered(0.1)), (0.0, reported(5.0)), (2.0, reported(None)))
    assert told is not None
    assert told.observed == (5.0,)


@pytest.mark.parametrize(
    ("more", "gate"),
    [({}, PASSED), ({"limit": "late picture"}, SLOWED), ({"reason": "too_old"}, HELD_BACK)],
)
def test_the_gate_is_told(more: dict[str, Any], gate: int) -> None:
    """A column says whether the command passed, was slowed or was refused."""
    told = frame(1.0, (0.0, steered(0.1, **more)), (0.0, reported()))
    assert told is not None
    assert told.gate == gate


def test_what_is_held_is_told() -> None:
    """Only the operator's commands count, and only while they are fresh."""
    begin: list[tuple[float, TapeEvent]] = [(0.0, steered(0.1)), (0.0, reported())]
    holds = (1.0, commanded(held=True))
    watchers = [
        (1.1, commanded(held=False, refused="not_your_turn")),
        (1.1, commanded(held=False, refused="other_turn")),
    ]
    told = [frame(at_s, *begin, holds, *watchers) for at_s in (0.9, 1.0, 1.2, 2.1)]
    assert [one.held for one in told if one is not None] == [False, True, True, False]
    turns = commanded(held=False).model_copy(update={"angular": 0.5})
    steers = frame(1.0, *begin, (1.0, turns))
    assert steers is not None
    assert steers.held


def test_a_robot_that_reports_nothing_has_frames() -> None:
    """Without any observation, the set-point is enough."""
    timeline = Timeline([(0.0, steered(0.1))], actions=("linear_mps",), observed=())
    assert timeline.frame(1.0) == DatasetFrame(1.0, (0.1,), (), PASSED, held=False)


@given(
    st.lists(st.tuples(st.floats(0, 100), st.floats(-2, 2)), min_size=1, max_size=50),
    st.floats(0, 101),
)
def test_every_frame_has_the_set_point_of_its_time(
    setpoints: list[tuple[float, float]], at_s: float
) -> None:
    """For any set-points, the action is that of the last at or before the capture."""
    setpoints.sort(key=lambda one: one[0])
    events: list[tuple[float, TapeEvent]] = [(0.0, reported(1.0))]
    events += [(sent_s, steered(linear_mps)) for sent_s, linear_mps in setpoints]
    number = bisect_right([sent_s for sent_s, _ in setpoints], at_s)
    told = frame(at_s, *events)
    if number == 0:
        assert told is None
    else:
        assert told is not None
        assert told.action == (setpoints[number - 1][1], 0.0)
