"""What the driver is told, and what becomes of a driver that raises."""

from __future__ import annotations

import pytest
from structlog.testing import capture_logs

from wax.control.gate import Setpoint
from wax.control.safe_driver import NOT_CONNECTED, SafeDriver
from wax.driver.checks import NO_ANSWER
from wax.driver.interface import STANDSTILL, Limits, RobotState, Twist
from wax.sentence import says

AHEAD = Twist(0.5, 0.0)


class Robot:
    """Notes what it is told; raises from the methods named in `broken`."""

    kind = "noted"
    limits = Limits(0.5, 1.0, axes=("pan",))

    def __init__(self) -> None:
        self.told: list[tuple[object, ...]] = []
        self.broken: set[str] = set()
        self.now = RobotState(connected=True, epoch=1)

    def _note(self, *call: object) -> None:
        if call[0] in self.broken:
            raise OSError("no bus")
        self.told.append(call)

    def open(self) -> None: ...

    def apply(self, twist: Twist, turn: int) -> None:
        self._note("apply", twist, turn)

    def set_axis(self, name: str, position: float, turn: int) -> None:
        self._note("set_axis", name, position, turn)

    def stop(self, turn: int) -> None:
        self._note("stop", turn)

    def close(self) -> None: ...

    def state(self) -> RobotState:
        if "state" in self.broken:
            raise OSError("no bus")
        return self.now

    def take(self) -> list[tuple[object, ...]]:
        told, self.told = self.told, []
        return told


@pytest.fixture
def robot() -> Robot:
    return Robot()


@pytest.fixture
def safe_driver(robot: Robot) -> SafeDriver:
    """Make a safe driver whose robot is there, and was told nothing since."""
    safe_driver = SafeDriver(robot)
    assert safe_driver.check(1) is None
    robot.take()
    return safe_driver


def test_it_stands_from_the_start(robot: Robot) -> None:
    """Before anything was said nothing moves, and the robot counts as not there."""
    safe_driver = SafeDriver(robot)
    assert not safe_driver.is_moving
    assert not safe_driver.state.connected
    assert safe_driver.failures == 0


def test_a_robot_that_is_not_there_is_told_of(safe_driver: SafeDriver, robot: Robot) -> None:
    """What the robot says is wrong with it comes first, then that it is not connected."""
    robot.now = RobotState(connected=False, epoch=1)
    assert safe_driver.check(1) == NOT_CONNECTED
    robot.now = RobotState(connected=False, epoch=1, problem="No port.")
    assert safe_driver.check(1) == says("No port.")


def test_a_robot_that_was_connected_anew_is_stopped(safe_driver: SafeDriver, robot: Robot) -> None:
    """It is stopped once, and where its axes stand is not known any more."""
    safe_driver.steer(Setpoint(axes={"pan": 0.5}), 1)
    assert not safe_driver.changes_axes({"pan": 0.5})
    robot.now = RobotState(connected=True, epoch=2)
    robot.take()
    safe_driver.check(3)
    safe_driver.check(3)
    assert robot.take() == [("stop", 3)]
    assert safe_driver.changes_axes({"pan": 0.5})


def test_only_axes_that_change_are_set(safe_driver: SafeDriver, robot: Robot) -> None:
    """A position is said once; that it would be said anew can be asked."""
    assert safe_driver.changes_axes({"pan": 0.5}) is True
    for _ in range(2):
        safe_driver.steer(Setpoint(axes={"pan": 0.5}), 1)
    assert safe_driver.changes_axes({"pan": 0.5}) is False
    assert safe_driver.changes_axes({"pan": 0.4}) is True
    stand = ("apply", STANDSTILL, 1)
    assert robot.take() == [stand, ("set_axis", "pan", 0.5, 1), stand]


def test_letting_go_is_a_set_point_of_standstill(safe_driver: SafeDriver, robot: Robot) -> None:
    """Motion that ends because the operator wants it to needs no stop."""
    safe_driver.steer(Setpoint(AHEAD), 1)
    safe_driver.steer(Setpoint(), 1)
    assert robot.take() == [("apply", AHEAD, 1), ("apply", STANDSTILL, 1)]


def test_motion_that_ends_with_a_reason_ends_with_a_stop(
    safe_driver: SafeDriver, robot: Robot
) -> None:
    """At the end of a soft stop, not on the way, and once."""
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


def test_lending_begins_with_one_stop(safe_driver: SafeDriver, robot: Robot) -> None:
    """Another reason is no other loan, and what was not lent is not taken back."""
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


def test_whether_a_lent_robot_moves_is_not_known(safe_driver: SafeDriver, robot: Robot) -> None:
    """What it said before somebody else had it does not count any more."""
    robot.now = RobotState(connected=True, epoch=1, moving=True)
    safe_driver.check(1)
    assert safe_driver.state.moving is True
    safe_driver.lend(says("It is being proved."), 1)
    safe_driver.check(1)
    assert safe_driver.state.moving is None


def test_a_robot_that_does_not_answer_is_stopped(safe_driver: SafeDriver, robot: Robot) -> None:
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
    assert robot.take() == [("stop", 1)]
    assert safe_driver.failures == 2


def test_what_a_driver_may_not_return_is_no_state(safe_driver: SafeDriver, robot: Robot) -> None:
    """A driver that returns something else does not answer."""
    robot.now = None  # type: ignore[assignment]  # somebody's driver
    with capture_logs():
        assert safe_driver.check(1) == NO_ANSWER


def test_a_failure_is_logged_once_until_all_is_well(robot: Robot) -> None:
    """From the very first call on, and anew after the robot has answered."""
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
