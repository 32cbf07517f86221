"""Encoder odometry."""

from __future__ import annotations

import math
from typing import Any

import pytest

from wax.config.robot import RobotSettings
from wax.robot.gpio.odometry import WINDOW_S, StepOdometry
from wax.robot.wheels import WheelGeometry


def odometry_of(steps_per_m: float, **robot: Any) -> StepOdometry:
    return StepOdometry(steps_per_m, WheelGeometry(RobotSettings.model_validate(robot)))


def test_a_circle_ends_where_it_began() -> None:
    """The right wheel circles the left one, which stands."""
    odometry = odometry_of(1000.0, wheel_base_m=0.3)
    for step in range(round(math.tau * 0.3 * 1000.0) + 1):
        odometry.take((0, step), step * 0.01)
    assert math.hypot(odometry.pose.x_m, odometry.pose.y_m) < 0.01
    assert abs(odometry.pose.heading_rad) < 0.01


def test_turning_left_on_the_spot_is_motion() -> None:
    """Wheels in opposite directions change the heading, not the position."""
    odometry = odometry_of(100.0, wheel_base_m=0.2)
    odometry.take((0, 0), 0.0)
    odometry.take((-10, 10), 0.1)
    assert odometry.pose.x_m == odometry.pose.y_m == 0.0
    assert odometry.pose.heading_rad == pytest.approx(1.0)
    assert odometry.moving
    assert odometry.motion.linear_mps == 0.0


def test_the_speed_is_that_of_the_last_moment() -> None:
    """Without a step for 0.2 s it is zero."""
    odometry = odometry_of(100.0, wheel_base_m=0.2)
    for number in range(11):
        odometry.take((number, number), number * 0.02)
    assert odometry.moving
    assert odometry.motion.linear_mps == pytest.approx(0.5)
    for number in range(12):
        odometry.take((10, 10), 0.2 + (number + 1) * 0.02)
    assert WINDOW_S == 0.2
    assert not odometry.moving
    assert odometry.motion.linear_mps == 0.0


def test_earlier_steps_do_not_count() -> None:
    """The first reading is where odometry begins."""
    odometry = odometry_of(100.0, wheel_base_m=0.2)
    odometry.take((500, 500), 0.0)
    assert odometry.pose.x_m == 0.0
    assert not odometry.moving


@pytest.mark.parametrize(
    ("base", "steps"), [("mecanum", (-50, 50, 50, -50)), ("omni", (-25, 25, 50))]
)
def test_wheels_that_roll_sideways_move_it_to_the_left(base: str, steps: tuple[int, ...]) -> None:
    """Speed and pose are those of four mecanum wheels, or of three omni wheels."""
    odometry = odometry_of(100.0, base=base)
    odometry.take((0,) * len(steps), 0.0)
    odometry.take(steps, 0.1)
    assert (odometry.pose.x_m, odometry.pose.y_m) == pytest.approx((0.0, 0.5))
    motion = odometry.motion
    assert (motion.linear_mps, motion.angular_rps) == pytest.approx((0.0, 0.0))
    assert motion.lateral_mps == pytest.approx(5.0)
