"""From a set-point to MAVLink's numbers."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.driver.interface import STANDSTILL, Limits, Twist
from wax.robot.mavlink.mapping import FULL, Sticks, Velocity, sticks, velocity

LIMITS = Limits(0.6, 1.5)
anything = st.floats(allow_nan=True, allow_infinity=True)


@pytest.mark.parametrize(
    ("twist", "pushed", "wanted"),
    [
        (STANDSTILL, Sticks(0, 0), Velocity(0.0, 0.0)),
        (Twist(0.6, 0.0), Sticks(0, 1000), Velocity(0.6, 0.0)),
        (Twist(-0.3, 0.0), Sticks(0, -500), Velocity(-0.3, 0.0)),
        (Twist(0.0, 1.5), Sticks(-1000, 0), Velocity(0.0, -1.5)),
        (Twist(0.3, -0.75), Sticks(500, 500), Velocity(0.3, 0.75)),
        (Twist(0.3, -0.75, 0.6), Sticks(500, 500), Velocity(0.3, 0.75)),
    ],
)
def test_left_is_negative_and_ahead_is_positive(
    twist: Twist, pushed: Sticks, wanted: Velocity
) -> None:
    """Full stick is the limit; velocities stay in m/s and rad/s; nothing goes sideways."""
    assert sticks(twist, LIMITS) == pushed
    assert velocity(twist, LIMITS) == wanted


@given(anything, anything)
def test_nothing_leaves_the_limits(linear_mps: float, angular_rps: float) -> None:
    """Any set-point is limited, and NaN or infinity is standstill."""
    twist = Twist(linear_mps, angular_rps)
    pushed, wanted = sticks(twist, LIMITS), velocity(twist, LIMITS)
    assert max(abs(pushed.y), abs(pushed.z)) <= FULL
    assert abs(wanted.vx_mps) <= 0.6
    assert abs(wanted.yaw_rate_rps) <= 1.5
    if not (math.isfinite(linear_mps) and math.isfinite(angular_rps)):
        assert (pushed, wanted) == (Sticks(0, 0), Velocity(0.0, 0.0))
