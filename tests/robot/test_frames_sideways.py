"""A robot that moves sideways, in the dialect `frames`: only a board that can is driven so."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest
from tests.firmware.core import Core, Kind, Settings
from tests.robot.dialect_robot import Robot, connected, framed, going

from wax.clock import SystemClock
from wax.config.robot import RobotSettings
from wax.driver.interface import STANDSTILL, Pose, Twist
from wax.errors import ConfigError
from wax.robot.build_driver import make_driver
from wax.robot.line.setpoints import Order
from wax.robot.serial.driver import SerialRobot
from wax.robot.serial.frames import AxisBody, DriveBody, HelloBody, MoveBody, StopBody

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tests.robot.conftest import Board

    from wax.robot.serial.frames_dialect import FramesDialect

CAN = 4
DIAGONAL = Order(Twist(0.424, -0.5, -0.3), 1)


def greeted(flags: int) -> tuple[FramesDialect, Robot]:
    """Give the dialect of a robot that moves sideways, whose hello was answered at 1.0 s."""
    dialect, robot = framed(moves_sideways=True), Robot()
    robot.hear(dialect.hello(1.0))
    robot.answer(dialect, 1.0, flags=flags)
    return dialect, robot


def settings(**robot: Any) -> RobotSettings:
    return RobotSettings.model_validate({"driver": "serial", "base": "mecanum"} | robot)


def dialect_of(robot: RobotSettings) -> FramesDialect:
    core = SerialRobot(robot, SystemClock())._core
    return core._dialect  # type: ignore[attr-defined,no-any-return]


# --- what is sent -------------------------------------------------------------------------


def test_a_board_that_can_is_sent_moves() -> None:
    """Each motion is one, in mm/s and mrad/s, with the turn and the time-to-live of a drive."""
    dialect, robot = greeted(CAN)
    assert dialect.answers(1.0)
    assert robot.hear(dialect.data_to_send(DIAGONAL, 1.0)[0]) == [MoveBody(424, -300, -500)]
    assert (robot.heard[-1].turn, robot.heard[-1].ttl_ms) == (1, 200)
    curve = Order(Twist(0.6, 1.5), 2, (("pan", 1.0),))
    told = robot.hear(dialect.data_to_send(curve, 1.01)[0])
    assert told == [StopBody(), MoveBody(600, 0, 1500), AxisBody(0, 10_000)]
    assert robot.hear(dialect.data_to_send(Order(STANDSTILL, 2), 1.02)[0]) == [StopBody()]


@pytest.mark.parametrize("flags", [0, 1, 2, 3])
def test_a_board_that_cannot_is_never_sent_a_motion(flags: int) -> None:
    """It is greeted and stopped as one that does not answer, and the problem says why."""
    dialect, robot = greeted(flags)
    assert not dialect.answers(1.0)
    assert dialect.overdue(1.0)
    assert dialect.complaint("/dev/x").code == "robot.not_sideways_on"
    for now_ms in range(1000, 3000, 10):
        for order in (DIAGONAL, going(1, 0)):
            robot.hear(dialect.data_to_send(order, now_ms / 1000)[0])
        robot.answer(dialect, now_ms / 1000, flags=flags)
        assert not dialect.answers(now_ms / 1000)
    assert {type(frame.body) for frame in robot.heard} == {HelloBody, StopBody}
    assert "max_lateral_mps" in str(dialect.complaint("/dev/x"))


def test_a_board_with_a_new_program_is_driven() -> None:
    """Once its reports say that it can, it is connected."""
    dialect, robot = greeted(0)
    robot.hear(dialect.data_to_send(DIAGONAL, 1.1)[0])
    robot.answer(dialect, 1.1, flags=CAN)
    assert dialect.answers(1.1)
    assert robot.hear(dialect.data_to_send(DIAGONAL, 1.11)[0]) == [MoveBody(424, -300, -500)]


def test_a_board_that_can_no_longer_is_greeted_anew() -> None:
    """A report without the bit ends the session, as its own watchdog would."""
    dialect, robot = greeted(CAN)
    robot.hear(dialect.data_to_send(DIAGONAL, 1.01)[0])
    robot.answer(dialect, 1.02, flags=1)
    assert not dialect.answers(1.02)
    told = robot.hear(dialect.data_to_send(DIAGONAL, 1.03)[0])
    assert [type(body) for body in told] == [HelloBody, StopBody]


def test_a_board_that_falls_silent_does_not_answer() -> None:
    """What it could not do is no longer the problem half a second later."""
    dialect, robot = greeted(0)
    robot.hear(dialect.data_to_send(DIAGONAL, 1.4)[0])
    assert dialect.complaint("/dev/x").code == "robot.not_sideways_on"
    robot.hear(dialect.data_to_send(DIAGONAL, 1.5)[0])
    assert dialect.complaint("/dev/x").code == "robot.no_answer_on"
    dialect, robot = greeted(0)
    dialect.hello(1.1)
    assert dialect.complaint("/dev/x").code == "robot.no_answer_on"


@pytest.mark.parametrize("flags", [0, CAN])
def test_a_robot_that_does_not_move_sideways_is_sent_drives(flags: int) -> None:
    """By a board that can, too: bytes and times are as for one from before."""
    dialect, robot = connected(1.0)
    robot.answer(dialect, 1.0, flags=flags)
    words, due_s = dialect.data_to_send(going(0.5, 0.5), 1.0)
    assert robot.hear(words) == [DriveBody(188, 412)]
    assert (len(words), due_s) == (22, 1.02)


@pytest.mark.parametrize(("base", "mmps"), [("mecanum", 250), ("omni", 120)])
def test_a_base_that_is_not_moved_sideways_turns_as_told(base: str, mmps: int) -> None:
    """A side drives as far as a wheel of the base would, and its ticks say as far."""
    sizes = {"wheel_base_m": 0.2, "axle_base_m": 0.3, "omni_radius_m": 0.12}
    ticks = {"serial": {"ticks_per_m": 1000.0}}
    robot = settings(base=base, max_lateral_mps=0, **sizes, **ticks)
    dialect, far = dialect_of(robot), Robot()
    far.hear(dialect.hello(1.0))
    far.answer(dialect, 1.0, flags=CAN)
    turning = Order(Twist(0.0, 1.0), 1)
    assert far.hear(dialect.data_to_send(turning, 1.0)[0])[-1] == DriveBody(-mmps, mmps)
    far.answer(dialect, 2.0, time_ms=1000, left_ticks=-mmps, right_ticks=mmps)
    assert dialect.reading.pose == pytest.approx(Pose(0.0, 0.0, 1.0))


def test_two_encoders_do_not_tell_where_it_is() -> None:
    """A turn and a way sideways look alike to them, so the place stays unknown."""
    robot = settings(serial={"ticks_per_m": 1000.0})
    dialect, far = dialect_of(robot), Robot()
    far.hear(dialect.hello(1.0))
    far.answer(dialect, 1.0, flags=CAN)
    far.answer(dialect, 1.1, time_ms=100, left_ticks=-50, right_ticks=50, flags=CAN)
    assert dialect.reading.pose is None
    assert dialect.reading.extra["right_ticks"] == 50.0


# --- the driver ---------------------------------------------------------------------------


def test_its_limits_are_the_configured_ones() -> None:
    """It moves sideways as fast as configured, and not at all with any other base."""
    assert make_driver(settings(), SystemClock()).limits.lateral_mps == 0.6
    slow = settings(base="omni", max_lateral_mps=0.2)
    assert make_driver(slow, SystemClock()).limits.lateral_mps == 0.2
    for other in (settings(base="differential"), settings(max_lateral_mps=0)):
        assert make_driver(other, SystemClock()).limits.lateral_mps == 0.0


def test_bytes_cannot_say_sideways() -> None:
    """The configuration is refused, with its key."""
    with pytest.raises(ConfigError, match=r"^robot\.max_lateral_mps: .* \"bytes\" has no byte"):
        make_driver(settings(serial={"dialect": "bytes"}), SystemClock())


@pytest.mark.parametrize("key", ["left_trim", "right_trim", "invert_left", "invert_right"])
def test_wheels_that_the_board_mixes_are_not_trimmed_here(key: str) -> None:
    """A key without effect would hide that a motor turns the wrong way."""
    value = 0.9 if key.endswith("trim") else True
    with pytest.raises(ConfigError, match=rf"^robot\.{key}: .* config\.h"):
        SerialRobot(settings(**{key: value}), SystemClock())
    SerialRobot(settings(base="differential", **{key: value}), SystemClock())


@pytest.fixture
def driver(board: Board) -> Iterator[SerialRobot]:
    serial = {"url": str(board.path), "reopen_s": 0.05}
    driver = SerialRobot(settings(serial=serial), SystemClock())
    driver.open()
    yield driver
    driver.close()


@pytest.mark.system
@pytest.mark.parametrize("kind", [Kind.MECANUM, Kind.OMNI])
def test_the_firmware_goes_where_it_is_driven(
    board: Board, driver: SerialRobot, kind: Kind
) -> None:
    """The real core turns its wheels to the side, and a stop ends that."""
    board.core = Core(Settings(kind=kind, fastest_mmps=800))
    board.until(lambda: driver.state().connected)
    driver.apply(STANDSTILL, 1)

    def goes() -> bool:
        driver.apply(Twist(0.0, 0.0, 0.6), 1)
        wheels = board.core.wheels_mmps
        return wheels[2] == 600 and wheels[0] < 0 < wheels[1]

    board.until(goes)
    assert driver.state().moving
    driver.stop(1)
    board.until(lambda: not any(board.core.wheels_mmps))


@pytest.mark.system
def test_a_board_with_two_sides_is_not_driven(board: Board, driver: SerialRobot) -> None:
    """It is not connected, gets nothing but hello and stop, and a sentence says what to do."""
    board.until(lambda: driver.state().problem is not None)
    problem = driver.state().said
    assert problem is not None
    assert problem.code == "robot.not_sideways_on"
    for twist in (STANDSTILL, Twist(0.3), Twist(0.0, 0.0, 0.3)):
        driver.apply(twist, 1)
    board.listen(0.3)
    assert {type(frame.body) for frame in board.frames()} == {HelloBody, StopBody}
    assert not driver.state().connected
