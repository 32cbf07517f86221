"""Odometry by the wheels' ticks."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.config.robot import RobotSettings
from wax.robot.serial.odometry import Odometry

PER_M = 2000.0
BASE_M = 0.3


def odometry(**robot: Any) -> Odometry:
    settings = {"wheel_base_m": BASE_M, "serial": {"ticks_per_m": PER_M}, **robot}
    return Odometry(RobotSettings.model_validate(settings))


def after(*reports: tuple[Any, ...], **robot: Any) -> Odometry:
    """Take reports of the wheels' ticks and their time."""
    found = odometry(**robot)
    for *ticks, at_s in reports:
        found.take(ticks, at_s)
    return found


def test_one_report_is_not_enough() -> None:
    """Before the second there is neither pose nor speed."""
    assert odometry().pose is None
    assert (after((5, 5, 0.0)).pose, after((5, 5, 0.0)).speeds) == (None, {})


def test_straight_ahead() -> None:
    """The ticks of a metre in two seconds are 1 m at 0.5 m/s."""
    found = after((100, 100, 1.0), (2100, 2100, 3.0))
    assert found.pose is not None
    assert (found.pose.x_m, found.pose.y_m, found.pose.heading_rad) == (1.0, 0.0, 0.0)
    assert found.speeds == {"left": 0.5, "right": 0.5}


def test_a_quarter_to_the_left() -> None:
    """Turning on the spot does not move it; afterwards ahead is to the left."""
    quarter = round(math.pi / 2 * BASE_M / 2 * PER_M)
    found = after((0, 0, 0.0), (-quarter, quarter, 1.0), (1000 - quarter, 1000 + quarter, 2.0))
    assert found.pose is not None
    assert found.pose.x_m == pytest.approx(0.0, abs=0.001)
    assert found.pose.y_m == pytest.approx(0.5, abs=0.001)
    assert found.pose.heading_rad == pytest.approx(math.pi / 2, abs=0.002)


def test_a_circle_ends_where_it_began() -> None:
    """After a circle in 100 reports the robot is back, with its first heading."""
    inner, outer = math.tau * 0.85 * PER_M, math.tau * 1.15 * PER_M
    steps = [(round(inner * n / 100), round(outer * n / 100), n / 10) for n in range(101)]
    found = after(*steps)
    assert found.pose is not None
    assert math.hypot(found.pose.x_m, found.pose.y_m) < 0.01
    assert abs(found.pose.heading_rad) < 0.01


def test_an_inverted_wheel_counts_backward() -> None:
    """The encoder of an inverted motor is inverted, too."""
    found = after((0, 0, 0.0), (-2000, 2000, 1.0), invert_left=True)
    assert found.pose is not None
    assert (found.pose.x_m, found.pose.heading_rad) == (1.0, 0.0)
    found = after((0, 0, 0.0), (2000, -2000, 1.0), invert_right=True)
    assert found.pose is not None
    assert (found.pose.x_m, found.pose.heading_rad) == (1.0, 0.0)


def test_a_report_of_other_wheels_is_refused() -> None:
    """Ticks of three wheels are no report of two."""
    with pytest.raises(ValueError, match="zip"):
        after((0, 0, 0, 0.0), (1, 1, 1, 1.0))


def test_counters_may_wrap() -> None:
    """After the largest 32-bit number ticks continue with the smallest."""
    found = after((2**31 - 50, -(2**31) + 50, 0.0), (-(2**31) + 50, 2**31 - 50, 1.0))
    assert found.speeds == {"left": 0.05, "right": -0.05}


@pytest.mark.parametrize("wheel", [0, 1])
def test_counters_that_restart_move_nothing(wheel: int) -> None:
    """After an impossible step the position is kept, and pose and speed are unknown at first."""
    jumped = (500_000, 0) if wheel == 0 else (0, -500_000)
    found = after((0, 0, 0.0), (2000, 2000, 1.0), (2000 + jumped[0], 2000 + jumped[1], 1.05))
    assert found.speeds == {}
    assert found.pose is None
    found.take((3000 + jumped[0], 3000 + jumped[1]), 2.05)
    assert found.pose is not None
    assert found.pose.x_m == 1.5


def test_a_possible_step_counts() -> None:
    """10 m/s plus 20 cm is possible; one tick more is not."""
    most = round((10.0 * 0.1 + 0.2) * PER_M)
    assert after((0, 0, 0.0), (most, most, 0.1)).speeds
    assert not after((0, 0, 0.0), (most, most + 1, 0.1)).speeds


def test_two_reports_of_one_moment_have_no_speed() -> None:
    """Without elapsed time there is none."""
    assert after((0, 0, 1.0), (10, 10, 1.0)).speeds == {}


def test_a_new_connection_keeps_the_position() -> None:
    """Counters from before a reconnection are not compared with later ones."""
    found = after((0, 0, 0.0), (2000, 2000, 1.0))
    found.forget()
    assert (found.pose, found.speeds) == (None, {})
    found.take((70, 70), 5.0)
    found.take((70, 70), 6.0)
    assert found.pose is not None
    assert found.pose.x_m == 1.0


def test_without_a_scale_nothing_is_known() -> None:
    """Ticks of unknown length give neither speed nor pose."""
    found = Odometry(RobotSettings())
    found.take((0, 0), 0.0)
    found.take((10, 10), 1.0)
    assert (found.pose, found.speeds) == (None, {})


@pytest.mark.parametrize(
    ("base", "ticks", "at"),
    [
        ("mecanum", (-1000, 1000, 1000, -1000), (0.0, 0.5)),
        ("mecanum", (0, 2000, 2000, 0), (0.5, 0.5)),
        ("omni", (-500, 500, 1000), (0.0, 0.5)),
    ],
)
def test_wheels_that_roll_sideways_move_the_pose_there(
    base: str, ticks: tuple[int, ...], at: tuple[float, float]
) -> None:
    """Four mecanum wheels, or three omni wheels, tell how far the robot moved to the left."""
    found = after((*[0] * len(ticks), 0.0), (*ticks, 1.0), base=base)
    assert found.pose is not None
    assert (found.pose.x_m, found.pose.y_m) == pytest.approx(at)
    assert found.pose.heading_rad == pytest.approx(0.0)
    assert len(found.speeds) == len(ticks)


def test_both_wheels_of_an_inverted_side_count_backward() -> None:
    """The encoders of both motors of the left side are inverted, too."""
    found = after(
        (0, 0, 0, 0, 0.0), (-2000, 2000, -2000, 2000, 1.0), base="mecanum", invert_left=True
    )
    assert found.pose is not None
    assert (found.pose.x_m, found.pose.y_m, found.pose.heading_rad) == (1.0, 0.0, 0.0)


numbers = st.integers(-(10**12), 10**12)


@given(st.lists(st.tuples(numbers, numbers, st.floats(0, 1e6)), max_size=6))
def test_no_report_raises(reports: list[tuple[int, int, float]]) -> None:
    """For any reports, the pose is finite and the heading within one turn."""
    pose = after(*reports).pose
    if pose is not None:
        assert math.isfinite(pose.x_m)
        assert math.isfinite(pose.y_m)
        assert abs(pose.heading_rad) <= math.pi
