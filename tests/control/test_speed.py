"""The speed that the robot may have."""

from __future__ import annotations

import math
from dataclasses import astuple, replace
from typing import Literal

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from tests.control.rules import RULES
from tests.control.velocity import velocity

from wax.control import speed
from wax.control.command import Command
from wax.control.reasons import Limit
from wax.control.stopping_distance import fastest_mps
from wax.control.video_freshness import VideoFreshness
from wax.driver.interface import STANDSTILL, Limits, Twist

TTL_S = 0.15
FULL = Command(1, 1, 0.0, -1.0, 0.5, True, "fast")


def test_nothing_against_it() -> None:
    """An operator who sees and can stop in time gets the speed they ask for."""
    assert speed.twist(FULL, VideoFreshness.CLEAR, TTL_S, RULES) == (Twist(-0.8, 1.0), None)


def test_what_is_left_of_the_speed() -> None:
    """The limits leave a share of what is asked for, whichever way it goes and at slow speed."""
    sideways = replace(FULL, linear=0.0, angular=0.0, lateral=-1.0)
    for command in (FULL, replace(FULL, speed="slow"), replace(FULL, linear=0.0), sideways):
        asked, _ = speed.twist(command, VideoFreshness.CLEAR, TTL_S, RULES)
        assert speed.share(command, asked, RULES) == pytest.approx(1.0)
    late, _ = speed.twist(FULL, VideoFreshness.LATE, TTL_S, RULES)
    assert speed.share(FULL, late, RULES) == pytest.approx(RULES.slow_fraction)
    for command in (replace(FULL, linear=0.0, angular=-1.0), sideways):
        late, _ = speed.twist(command, VideoFreshness.LATE, TTL_S, RULES)
        assert speed.share(command, late, RULES) == pytest.approx(RULES.slow_fraction)
    assert speed.share(FULL, STANDSTILL, RULES) == 0.0


@pytest.mark.parametrize("command", [None, replace(FULL, linear=0.0, angular=0.0)])
def test_nothing_is_left_out_of_nothing(command: Command | None) -> None:
    """Without a command for motion nothing is slowed."""
    assert speed.share(command, STANDSTILL, RULES) == 1.0


@given(
    hands=st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1)),
    pace=st.sampled_from(["slow", "fast"]),
    limits=st.builds(
        Limits,
        st.sampled_from([0.0, 0.8]),
        st.sampled_from([0.0, 1.0]),
        lateral_mps=st.sampled_from([0.0, 0.8, 0.3]),
    ),
    freshness=st.sampled_from(VideoFreshness),
)
@example((5e-324, 1.0, 0.0), "slow", Limits(0.8, 1.0), VideoFreshness.LATE)
@example((1.0, 0.0, 0.0), "fast", Limits(0.0, 1.0), VideoFreshness.LATE)
@example((1.0, 0.0, 5e-324), "slow", Limits(0.0, 1.0, lateral_mps=0.3), VideoFreshness.LATE)
def test_what_is_left_is_a_share(
    hands: tuple[float, float, float],
    pace: Literal["slow", "fast"],
    limits: Limits,
    freshness: VideoFreshness,
) -> None:
    """The share is from 0 to 1 for any command and robot, even if a part is 0."""
    linear, angular, lateral = hands
    command = replace(FULL, linear=linear, angular=angular, lateral=lateral, speed=pace)
    rules = replace(RULES, limits=limits)
    lowered, _ = speed.twist(command, freshness, TTL_S, rules, 0.5)
    assert 0.0 <= speed.share(command, lowered, rules) <= 1.0


@given(linear=st.floats(-1, 1), lateral=st.floats(-1, 1), pace=st.sampled_from(["slow", "fast"]))
@example(linear=1.0, lateral=-1.0, pace="fast")
@example(linear=1.0, lateral=0.61, pace="fast")
@example(linear=1.0, lateral=0.61, pace="slow")
def test_a_diagonal_is_no_faster_than_straight_ahead(
    linear: float, lateral: float, pace: Literal["slow", "fast"]
) -> None:
    """Ahead and sideways at once are limited by their length, which counts as no limit lowered."""
    rules = replace(RULES, limits=Limits(0.8, 2.0, lateral_mps=0.8))
    command = replace(FULL, linear=linear, lateral=lateral, speed=pace)
    own = RULES.slow_fraction if pace == "slow" else 1.0
    for sight in (VideoFreshness.CLEAR, VideoFreshness.LATE)[: 1 + (pace == "slow")]:
        twist, why = speed.twist(command, sight, TTL_S, rules, own)
        asked = complex(linear, lateral)
        assert twist.speed_mps == pytest.approx(0.8 * own * min(1.0, abs(asked)), rel=1e-9)
        assert velocity(twist) * abs(asked) == pytest.approx(asked * twist.speed_mps, rel=1e-9)
        assert why is None


def test_the_limit_sideways_is_the_robots_own() -> None:
    """Sideways it is as fast as its limit there; a base that cannot ignores what is asked of it."""
    diagonal = replace(FULL, lateral=1.0)
    twist, why = speed.twist(diagonal, VideoFreshness.CLEAR, TTL_S, RULES)
    assert astuple(twist) == pytest.approx((-0.8 / math.sqrt(2), 1.0, 0.4 / math.sqrt(2)))
    assert why is None
    rules = replace(RULES, limits=replace(RULES.limits, lateral_mps=0.0))
    for most, whose in ((1.0, None), (0.25, Limit.BY_HOST)):
        wheeled, why = speed.twist(diagonal, VideoFreshness.CLEAR, TTL_S, rules, most)
        assert (wheeled, why) == (Twist(-0.8, 1.0).scaled(most), whose)
        assert speed.share(diagonal, wheeled, rules) == pytest.approx(most)


def test_fine() -> None:
    """Slow speed scales the command, and is not reported as a limit."""
    fine = replace(FULL, speed="slow")
    assert speed.twist(fine, VideoFreshness.CLEAR, TTL_S, RULES) == (Twist(-0.4, 0.5), None)


def test_the_host_limits_the_speed() -> None:
    """Above the host's fraction both speeds are scaled alike; below it nothing changes."""
    twist, why = speed.twist(FULL, VideoFreshness.CLEAR, TTL_S, RULES, 0.25)
    assert (twist, why) == (Twist(-0.2, 0.25), Limit.BY_HOST)
    half = replace(FULL, linear=-0.5, angular=0.25)
    assert speed.twist(half, VideoFreshness.CLEAR, TTL_S, RULES, 0.25)[0] == twist
    slow = replace(FULL, linear=0.2, angular=0.1)
    assert speed.twist(slow, VideoFreshness.CLEAR, TTL_S, RULES, 0.25)[1] is None
    late, why = speed.twist(FULL, VideoFreshness.LATE, TTL_S, RULES, 0.25)
    assert (late, why) == (Twist(-0.2, 0.25), Limit.BY_HOST)


@pytest.mark.parametrize(
    ("sight", "why"),
    [(VideoFreshness.LATE, Limit.LATE_PICTURE), (VideoFreshness.OFF, Limit.NO_PICTURE)],
)
def test_without_a_fresh_picture_no_faster_than_fine(sight: VideoFreshness, why: Limit) -> None:
    """With a late picture or none both speeds stay within slow speed, on the same curve."""
    assert speed.twist(FULL, sight, TTL_S, RULES) == (Twist(-0.4, 0.5), why)
    turning = replace(FULL, linear=0.2, angular=1.0)
    assert speed.twist(turning, sight, TTL_S, RULES) == (Twist(0.1 * 0.8, 1.0), why)
    slower, found = speed.twist(replace(FULL, linear=0.8, angular=0.0), sight, TTL_S, RULES)
    assert slower.linear_mps == pytest.approx(0.4)
    assert found is why


@pytest.mark.parametrize("sight", [VideoFreshness.LATE, VideoFreshness.OFF])
@pytest.mark.parametrize(
    ("command", "expected"),
    [
        (replace(FULL, speed="slow"), Twist(-0.4, 0.5)),
        (replace(FULL, linear=0.5, angular=-0.25), Twist(0.4, -0.5)),
        (replace(FULL, linear=0.0, angular=0.0), STANDSTILL),
    ],
)
def test_who_is_slow_already_is_let_be(
    sight: VideoFreshness, command: Command, expected: Twist
) -> None:
    """A command within slow speed is neither lowered nor reported."""
    assert speed.twist(command, sight, TTL_S, RULES) == (expected, None)


def test_stopping_distance_keeps_the_curve() -> None:
    """The speed from which the robot can stop counts in its direction, and scales all alike."""
    rules = replace(RULES, max_stop_distance_m=0.1)
    diagonal = replace(FULL, linear=0.6, lateral=0.8)
    twist, why = speed.twist(diagonal, VideoFreshness.CLEAR, TTL_S, rules)
    assert twist.speed_mps == pytest.approx(fastest_mps(TTL_S, rules))
    assert astuple(twist) == pytest.approx(
        astuple(Twist(0.48, 1.0, 0.32).scaled(twist.linear_mps / 0.48))
    )
    assert why is Limit.STOPPING_DISTANCE
    twist, why = speed.twist(FULL, VideoFreshness.CLEAR, TTL_S, rules)
    assert twist.linear_mps == pytest.approx(-fastest_mps(TTL_S, rules))
    assert twist.angular_rps / twist.linear_mps == pytest.approx(1.0 / -0.8)
    assert why is Limit.STOPPING_DISTANCE


def test_as_fast_as_it_may_be_is_not_lowered() -> None:
    """No limit is reported at exactly the speed from which the robot can stop."""
    fastest = fastest_mps(TTL_S, RULES)
    rules = replace(RULES, limits=replace(RULES.limits, linear_mps=fastest))
    command = replace(FULL, linear=1.0, angular=0.0)
    assert speed.twist(command, VideoFreshness.CLEAR, TTL_S, rules) == (Twist(fastest, 0.0), None)
    # Over a longer link the same speed is too fast, and only the link is to blame.
    assert speed.twist(command, VideoFreshness.CLEAR, 0.4, rules)[1] is Limit.LONG_DELAY


def test_turning_on_the_spot_needs_no_distance() -> None:
    """A robot that only turns is not slowed by the distance that it could travel."""
    rules = replace(RULES, max_stop_distance_m=0.01)
    turning = replace(FULL, linear=0.0, angular=1.0)
    assert speed.twist(turning, VideoFreshness.CLEAR, TTL_S, rules) == (Twist(0.0, 2.0), None)


def test_the_line_is_to_blame_only_where_it_is() -> None:
    """A speed that a fast link would allow is limited by the link, else by the robot."""
    rules = replace(RULES, max_stop_distance_m=0.35)
    assert fastest_mps(0.15, rules) > 0.8 > fastest_mps(0.4, rules)
    assert speed.twist(FULL, VideoFreshness.CLEAR, 0.15, rules)[1] is None
    assert speed.twist(FULL, VideoFreshness.CLEAR, 0.4, rules)[1] is Limit.LONG_DELAY
    rules = replace(RULES, max_stop_distance_m=0.25)
    assert speed.twist(FULL, VideoFreshness.CLEAR, 0.4, rules)[1] is Limit.STOPPING_DISTANCE


def test_the_strictest_limit_is_told() -> None:
    """If two limits lower the speed, the one that lowered it most is reported."""
    rules = replace(RULES, max_stop_distance_m=0.05)
    twist, why = speed.twist(FULL, VideoFreshness.LATE, TTL_S, rules)
    assert twist.linear_mps == pytest.approx(-fastest_mps(TTL_S, rules))
    assert why is Limit.STOPPING_DISTANCE
