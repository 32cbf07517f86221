"""What every driver checks for itself."""

from __future__ import annotations

import math
import sys
from dataclasses import astuple, replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.control.velocity import fraction

from wax.driver.checks import TurnFence, checked, share_of, unit, within
from wax.driver.interface import STANDSTILL, Limits, RobotState, Twist

LIMITS = Limits(linear_mps=0.6, angular_rps=1.5, lateral_mps=0.3)


def test_only_the_highest_turn_is_admitted() -> None:
    """A turn lower than one already seen is refused for ever; the same or a higher one is not."""
    fence = TurnFence()
    assert [fence.admits(turn) for turn in (3, 3, 2, 5, 3, 4, 5)] == [
        True, True, False, True, False, False, True,
    ]  # fmt: skip


@given(st.builds(Twist, st.floats(), st.floats(), st.floats()))
def test_no_number_passes_the_limits(told: Twist) -> None:
    """For any input, NaN and infinity included, the result is within the limits in any direction.

    It uses no greater share of them than `share_of` says.
    """
    safe = within(told, LIMITS)
    assert abs(safe.linear_mps) <= LIMITS.linear_mps
    assert abs(safe.lateral_mps) <= LIMITS.lateral_mps
    assert abs(safe.angular_rps) <= LIMITS.angular_rps
    assert fraction(safe, LIMITS) <= 1.0 + 1e-9
    assert share_of(safe, LIMITS) <= 1.0 + 1e-9
    if not all(map(math.isfinite, astuple(told))):
        assert safe == STANDSTILL


parts = st.floats(-50, 50)


@given(st.builds(Twist, parts, parts, st.one_of(st.just(0.0), parts)))
def test_a_curve_stays_the_same_curve(told: Twist) -> None:
    """All three speeds are scaled by one factor, and not at all within the limits."""
    safe, share = within(told, LIMITS), max(fraction(told, LIMITS), abs(told.angular_rps) / 1.5)
    assert share_of(told, LIMITS) == pytest.approx(share)
    assert astuple(safe) == pytest.approx(astuple(told.scaled(1 / max(1.0, share))))
    if share < 1.0:
        assert safe == told


def test_a_limit_of_zero_takes_its_part_away() -> None:
    """A robot that cannot turn still goes straight at the full speed."""
    straight = Limits(linear_mps=0.6, angular_rps=0.0)
    assert within(Twist(0.5, 1.0), straight) == Twist(0.5, 0.0)
    assert within(Twist(1.0, 0.5), Limits(linear_mps=0.0, angular_rps=1.5)) == Twist(0.0, 0.5)
    assert within(Twist(0.6, 1.5, 9.0), Limits(0.6, 1.5)) == Twist(0.6, 1.5)


def test_an_axis_stays_in_its_range() -> None:
    """A position beyond -1…1 is clipped; one that is no number becomes the middle."""
    assert [unit(p) for p in (2.0, -7.0, 0.25, math.nan, math.inf)] == [1.0, -1.0, 0.25, 0.0, 0.0]


def test_a_state_passes_as_it_is() -> None:
    """A driver's state is checked, and not changed."""
    for ttl_s in (None, 0, 0.5):
        state = RobotState(connected=True, bumpers=2, ttl_s=ttl_s)
        assert checked(state) is state


def test_a_state_may_have_as_many_gauges_as_are_allowed() -> None:
    """Up to `MAX_GAUGES`, with any finite number, pass as they are; one more is refused."""
    gauges = {f"g{number}": sys.float_info.max * (-1) ** number for number in range(32)}
    state = RobotState(connected=True, gauges=gauges)
    assert checked(state) is state
    for wrong in (gauges | {"more": 0.0}, {7: 0.0}):
        with pytest.raises(TypeError, match="for gauges, not at most 32 numbers by name"):
            checked(replace(state, gauges=wrong))  # type: ignore[arg-type]  # as a plug-in may


@pytest.mark.parametrize(
    ("told", "sentence"),
    [
        (None, r"state\(\) returned None, not a RobotState"),
        ({"connected": True}, r"returned \{'connected': True\}, not a RobotState"),
        (RobotState(connected=True, bumpers=None), "has None for bumpers, not their bits"),  # type: ignore[arg-type]  # as a plug-in may
        (RobotState(connected=True, ttl_s=-1.0), "has -1.0 for ttl_s, not seconds or None"),
        (RobotState(connected=True, ttl_s=math.nan), "has nan for ttl_s"),
        (RobotState(connected=True, ttl_s=math.inf), "has inf for ttl_s"),
        (RobotState(connected=True, ttl_s="0.5"), "has '0.5' for ttl_s"),  # type: ignore[arg-type]  # likewise
        (RobotState(connected=True, gauges=["warm"]), r"has \['warm'\] for gauges, not at most"),  # type: ignore[arg-type]  # likewise
        (RobotState(connected=True, aboard="Ada"), "has 'Ada' for aboard, not an Aboard"),  # type: ignore[arg-type]  # likewise
    ],
)
def test_what_is_no_state_is_refused(told: object, sentence: str) -> None:
    """A plug-in may return anything; the sentence says what it was."""
    with pytest.raises(TypeError, match=sentence):
        checked(told)


@pytest.mark.parametrize(
    "wrong", [None, "warm", math.nan, -math.inf, True, [], pytest.param(10**400, id="huge")]
)
def test_a_gauge_that_is_no_number_is_left_out(wrong: Any) -> None:
    """A sensor that a driver cannot read costs only its own gauge, which is then left out."""
    state = RobotState(connected=True, gauges={"motor_c": 40.5, "arm_c": wrong, "turns": 7})
    assert checked(state) == replace(state, gauges={"motor_c": 40.5, "turns": 7})


def test_what_a_robot_tells_is_given_by_keyword() -> None:
    """A fourth value, which was `moving` in 0.9.0, is not taken for a person aboard."""
    values: list[Any] = [True, None, 1, False]
    with pytest.raises(TypeError, match="positional"):
        RobotState(*values)
