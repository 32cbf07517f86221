"""Where a robot is by its wheels' ticks."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.config.settings import RobotSettings
from wax.robot.serial.odometry import Odometry

PER_M = 2000.0
BASE_M = 0.3


def odometry(**robot: bool) -> Odometry:
    settings = {"wheel_base_m": BASE_M, "serial": {"ticks_per_m": PER_M}, **robot}
    return Odometry(RobotSettings.model_validate(settings))


def after(*reports: tuple[int, int, float], **robot: bool) -> Odometry:
    found = odometry(**robot)
    for left, right, at_s in reports:
        found.take(left, right, at_s)
    return found


def test_one_report_tells_nothing() -> None:
    """Before the second there is neither a place nor a speed."""
    assert odometry().pose is None
    assert (after((5, 5, 0.0)).pose, after((5, 5, 0.0)).speeds) == (None, None)


def test_straight_ahead() -> None:
    """A metre's ticks in two seconds are a metre at half a metre a second."""
    found = after((100, 100, 1.0), (2100, 2100, 3.0))
    assert found.pose is not None
    assert (found.pose.x_m, found.pose.y_m, found.pose.heading_rad) == (1.0, 0.0, 0.0)
    assert found.speeds is not None
    assert (found.speeds.left_mps, found.speeds.right_mps) == (0.5, 0.5)


def test_a_quarter_to_the_left() -> None:
    """On the spot it turns without going anywhere; from then on ahead is to the left."""
    quarter = round(math.pi / 2 * BASE_M / 2 * PER_M)
    found = after((0, 0, 0.0), (-quarter, quarter, 1.0), (1000 - quarter, 1000 + quarter, 2.0))
    assert found.pose is not None
    assert found.pose.x_m == pytest.approx(0.0, abs=0.001)
    assert found.pose.y_m == pytest.approx(0.5, abs=0.001)
    assert found.pose.heading_rad == pytest.approx(math.pi / 2, abs=0.002)


def test_a_circle_ends_where_it_began() -> None:
    """Round a circle in a hundred reports it comes back, and its heading has gone round once."""
    inner, outer = math.tau * 0.85 * PER_M, math.tau * 1.15 * PER_M
    steps = [(round(inner * n / 100), round(outer * n / 100), n / 10) for n in range(101)]
    found = after(*steps)
    assert found.pose is not None
    assert math.hypot(found.pose.x_m, found.pose.y_m) < 0.01
    assert abs(found.pose.heading_rad) < 0.01


def test_an_inverted_wheel_counts_backward() -> None:
    """Where a motor is wired the other way round, so is its encoder."""
    found = after((0, 0, 0.0), (-2000, 2000, 1.0), invert_left=True)
    assert found.pose is not None
    assert (found.pose.x_m, found.pose.heading_rad) == (1.0, 0.0)
    found = after((0, 0, 0.0), (2000, -2000, 1.0), invert_right=True)
    assert found.pose is not None
    assert (found.pose.x_m, found.pose.heading_rad) == (1.0, 0.0)


def test_counters_may_wrap() -> None:
    """Past the largest number of 32 bits ticks go on from the smallest."""
    found = after((2**31 - 50, -(2**31) + 50, 0.0), (-(2**31) + 50, 2**31 - 50, 1.0))
    assert found.speeds is not None
    assert (found.speeds.left_mps, found.speeds.right_mps) == (0.05, -0.05)


@pytest.mark.parametrize("wheel", [0, 1])
def test_counters_that_began_anew_move_nothing(wheel: int) -> None:
    """A wheel cannot have turned so far; the robot stays, and its speed is not known meanwhile."""
    jumped = (500_000, 0) if wheel == 0 else (0, -500_000)
    found = after((0, 0, 0.0), (2000, 2000, 1.0), (2000 + jumped[0], 2000 + jumped[1], 1.05))
    assert found.speeds is None
    assert found.pose is None
    found.take(3000 + jumped[0], 3000 + jumped[1], 2.05)
    assert found.pose is not None
    assert found.pose.x_m == 1.5


def test_what_is_possible_is_believed() -> None:
    """10 m/s and 20 cm more are; a tick more than that is not."""
    most = round((10.0 * 0.1 + 0.2) * PER_M)
    assert after((0, 0, 0.0), (most, most, 0.1)).speeds is not None
    assert after((0, 0, 0.0), (most, most + 1, 0.1)).speeds is None


def test_two_reports_of_one_moment_tell_nothing() -> None:
    """Without time there is no speed."""
    assert after((0, 0, 1.0), (10, 10, 1.0)).speeds is None


def test_a_new_connection_keeps_the_place() -> None:
    """What the counters said before it is not compared with what they say after."""
    found = after((0, 0, 0.0), (2000, 2000, 1.0))
    found.forget()
    assert (found.pose, found.speeds) == (None, None)
    found.take(70, 70, 5.0)
    found.take(70, 70, 6.0)
    assert found.pose is not None
    assert found.pose.x_m == 1.0


def test_without_a_scale_nothing_is_known() -> None:
    """Ticks of no known length give neither speed nor place."""
    found = Odometry(RobotSettings())
    found.take(0, 0, 0.0)
    found.take(10, 10, 1.0)
    assert (found.pose, found.speeds) == (None, None)


numbers = st.integers(-(10**12), 10**12)


@given(st.lists(st.tuples(numbers, numbers, st.floats(0, 1e6)), max_size=6))
def test_no_report_raises(reports: list[tuple[int, int, float]]) -> None:
    """Whatever is reported, the place is finite and the heading within one turn."""
    pose = after(*reports).pose
    if pose is not None:
        assert math.isfinite(pose.x_m)
        assert math.isfinite(pose.y_m)
        assert abs(pose.heading_rad) <= math.pi
