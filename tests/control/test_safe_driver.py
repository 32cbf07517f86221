"""The calls that the driver gets, and how a driver that raises is handled."""

from __future__ import annotations

import pytest
from structlog.testing import capture_logs
from tests.control.rig import EquippedDriver, FakeDriver

from wax.control.controls import ActiveControl
from wax.control.gate import Setpoint
from wax.control.safe_driver import NOT_CONNECTED, SafeDriver
from wax.driver.checks import NO_ANSWER
from wax.driver.interface import STANDSTILL, RobotState, Twist
from wax.sentence import says

AHEAD = Twist(0.5, 0.0)


@pytest.fixture
def robot() -> FakeDriver:
    return FakeDriver()


@pytest.fixture
def safe_driver(robot: FakeDriver) -> SafeDriver:
    """Make a safe driver whose robot is connected and has no calls recorded since."""
    safe_driver = SafeDriver(robot)
    assert safe_driver.check(1) is None
    robot.take()
    return safe_driver


def test_it_stands_from_the_start(robot: FakeDriver) -> None:
    """Before the first call nothing moves, and the robot counts as not connected."""
    safe_driver = SafeDriver(robot)
    assert not safe_driver.is_moving
    assert not safe_driver.state.connected
    assert safe_driver.failures == 0


def test_a_robot_that_is_not_there_is_told_of(safe_driver: SafeDriver, robot: FakeDriver) -> None:
    """A problem that the robot reports is shown before the missing connection."""
    robot.now = RobotState(connected=False, epoch=1)
    assert safe_driver.check(1) == NOT_CONNECTED
    robot.now = RobotState(connected=False, epoch=1, problem="No port.")
    assert safe_driver.check(1) == says("No port.")


def test_a_robot_that_was_connected_anew_is_stopped(
    safe_driver: SafeDriver, robot: FakeDriver
) -> None:
    """A robot that has reconnected is stopped once, and its axes' positions are unknown."""
    safe_driver.steer(Setpoint(axes={"pan": 0.5}), 1)
    assert not safe_driver.changes_axes({"pan": 0.5})
    robot.now = RobotState(connected=True, epoch=2)
    robot.take()
    safe_driver.check(3)
    safe_driver.check(3)
    assert robot.take() == [("stop", 3)]
    assert safe_driver.changes_axes({"pan": 0.5})


def test_only_axes_that_change_are_set(safe_driver: SafeDriver, robot: FakeDriver) -> None:
    """A position is sent once, and `changes_axes` says whether one would be sent."""
    assert safe_driver.changes_axes({"pan": 0.5}) is True
    for _ in range(2):
        safe_driver.steer(Setpoint(axes={"pan": 0.5}), 1)
    assert safe_driver.changes_axes({"pan": 0.5}) is False
    assert safe_driver.changes_axes({"pan": 0.4}) is True
    stand = ("apply", STANDSTILL, 1)
    assert robot.take() == [stand, ("set_axis", "pan", 0.5, 1), stand]


def test_letting_go_is_a_set_point_of_standstill(
    safe_driver: SafeDriver, robot: FakeDriver
) -> None:
    """Motion that the operator ends needs no stop, just standstill."""
    for twist in (AHEAD, Twist(lateral_mps=-0.1), STANDSTILL):
        safe_driver.steer(Setpoint(twist), 1)
        assert safe_driver.is_moving is (twist is not STANDSTILL)
        assert robot.take() == [("apply", twist, 1)]


def test_motion_that_ends_with_a_reason_ends_with_a_stop(
    safe_driver: SafeDriver, robot: FakeDriver
) -> None:
    """A soft stop ends with one `Driver.stop`, at standstill and not before."""
    slow = Twist(0.1, 0.0)
    for twist in (AHEAD, slow, STANDSTILL, STANDSTILL):
        safe_driver.steer(Setpoint(twist, reason=None if twist is AHEAD else says("Why.")), 2)
    assert robot.take() == [
        ("apply", AHEAD, 2),
        ("apply", slow, 2),
        ("stop", 2),
        ("apply", STANDSTILL, 2),
        ("apply", STANDSTILL, 2),
    ]


def test_lending_begins_with_one_stop(safe_driver: SafeDriver, robot: FakeDriver) -> None:
    """Lending stops the robot once, even if the reason changes or nothing was lent."""
    safe_driver.lend(None, 1)
    assert robot.take() == []
    safe_driver.lend(says("It is being proved."), 1)
    safe_driver.lend(says("It is being proved, still."), 1)
    safe_driver.stop(1)
    safe_driver.steer(Setpoint(AHEAD), 1)
    assert robot.take() == [("stop", 1)]
    assert safe_driver.check(1) == says("It is being proved, still.")
    safe_driver.lend(None, 1)
    assert safe_driver.check(1) is None
    assert robot.take() == [("stop", 1)]


def active(*, is_held: bool) -> dict[str, ActiveControl]:
    return {"lamp": ActiveControl(1.0, value=True, moves=False, is_held=is_held)}


@pytest.mark.parametrize("is_held", [True, False])
def test_only_what_is_held_is_released(is_held: bool) -> None:
    """A control that was set keeps its value when it is operated no more."""
    robot = EquippedDriver()
    safe_driver = SafeDriver(robot)
    safe_driver.operate(active(is_held=is_held), 1)
    safe_driver.operate({}, 1)
    told = [("control", "lamp", value, 1) for value in (True, False)]
    assert robot.take() == told[: 1 + is_held]


def test_a_lent_driver_is_not_operated() -> None:
    """While the driver is lent no control reaches it."""
    robot = EquippedDriver()
    safe_driver = SafeDriver(robot)
    safe_driver.lend(says("It is being proved."), 1)
    robot.take()
    assert safe_driver.operate(active(is_held=True), 1) is None
    assert robot.take() == []


def test_whether_a_lent_robot_moves_is_not_known(
    safe_driver: SafeDriver, robot: FakeDriver
) -> None:
    """While the driver is lent it is unknown whether the robot moves."""
    robot.now = RobotState(connected=True, epoch=1, moving=True)
    safe_driver.check(1)
    assert safe_driver.state.moving is True
    safe_driver.lend(says("It is being proved."), 1)
    safe_driver.check(1)
    assert safe_driver.state.moving is None


def test_a_robot_that_does_not_answer_is_stopped(
    safe_driver: SafeDriver, robot: FakeDriver
) -> None:
    """Whatever raises, the robot is stopped, counted, and not known to move."""
    robot.now = RobotState(connected=True, epoch=1, moving=True)
    safe_driver.check(1)
    safe_driver.steer(Setpoint(AHEAD), 1)
    robot.take()
    robot.broken = {"state"}
    with capture_logs():
        assert safe_driver.check(1) == NO_ANSWER
    assert (safe_driver.state.problem, safe_driver.state.moving) == (NO_ANSWER, None)
    assert robot.take() == [("stop", 1)]
    assert not safe_driver.is_moving
    robot.broken = {"apply"}
    with capture_logs():
        assert safe_driver.steer(Setpoint(AHEAD), 1) == NO_ANSWER
    assert robot.take() == [("apply", AHEAD, 1), ("stop", 1)]
    assert safe_driver.failures == 2


def test_what_a_driver_may_not_return_is_no_state(
    safe_driver: SafeDriver, robot: FakeDriver
) -> None:
    """A driver that returns no valid state counts as not answering."""
    robot.now = None  # type: ignore[assignment]  # somebody's driver
    with capture_logs():
        assert safe_driver.check(1) == NO_ANSWER


def test_a_failure_is_logged_once_until_all_is_well(robot: FakeDriver) -> None:
    """A failure is logged once, and again only after the robot has worked in between."""
    safe_driver = SafeDriver(robot)
    with capture_logs() as logs:
        robot.broken = {"state", "apply", "stop"}
        for _ in range(3):
            safe_driver.steer(Setpoint(reason=safe_driver.check(1)), 1)
        assert len(logs) == 1
        robot.broken = {"state"}
        safe_driver.steer(Setpoint(reason=safe_driver.check(1)), 1)
        assert len(logs) == 1
        robot.broken = set()
        safe_driver.steer(Setpoint(reason=safe_driver.check(1)), 1)
        robot.broken = {"stop"}
        safe_driver.stop(1)
        assert len(logs) == 2
