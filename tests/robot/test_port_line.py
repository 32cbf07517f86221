"""The serial robot on a real pseudo-terminal."""

from __future__ import annotations

import itertools
import os
import socket
import threading
import time
from typing import TYPE_CHECKING, Any

import pytest
import serial
from tests.firmware.core import Core

from wax.clock import SystemClock
from wax.config.robot import RobotSettings
from wax.config.serial import SerialSettings
from wax.driver.interface import STANDSTILL, RobotState, Twist
from wax.robot.line.kept_line import KeptLine
from wax.robot.serial import frames_dialect
from wax.robot.serial.driver import SerialRobot
from wax.robot.serial.frames import (
    NO_SESSION,
    AxisBody,
    DriveBody,
    Frame,
    HelloBody,
    ReportBody,
    StopBody,
    encode,
)
from wax.robot.serial.port_line import PortLine

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from tests.robot.conftest import Board

    from wax.sentence import Sentence

pytestmark = pytest.mark.system

AHEAD = Twist(0.5, 0.0)
PATIENT_MS = 1000
"""The longest time-to-live, so that a held set-point survives a busy machine."""
DIALECTS = pytest.mark.parametrize("dialect", ["frames", "bytes"])


@pytest.fixture
def connect(board: Board) -> Iterator[Callable[..., SerialRobot]]:
    """Make and open robots on the board's line; close them at the end."""
    robots: list[SerialRobot] = []

    def connected(dialect: str = "frames", **robot: Any) -> SerialRobot:
        serial = {"url": str(board.path), "dialect": dialect, "reopen_s": 0.05}
        serial |= {"ttl_ms": PATIENT_MS} | robot.pop("serial", {})
        settings = RobotSettings.model_validate({"driver": "serial", "serial": serial} | robot)
        robots.append(SerialRobot(settings, SystemClock()))
        robots[-1].open()
        return robots[-1]

    yield connected
    for robot in robots:
        robot.close()


def eventually(
    robot: SerialRobot, so: Callable[[RobotState], bool], within_s: float = 10.0
) -> float:
    """Wait until `so` holds for the state; return the time in s."""
    start_s = time.monotonic()
    while not so(robot.state()):
        assert time.monotonic() - start_s < within_s, robot.state()
        time.sleep(0.002)
    return time.monotonic() - start_s


def _now_ms() -> int:
    return int(time.monotonic() * 1000.0)


def online(robot: SerialRobot) -> None:
    eventually(robot, lambda state: state.connected)


def hold(
    robot: SerialRobot, board: Board, twist: Twist, turn: int, enough: Callable[[], bool]
) -> None:
    """Send a motion repeatedly, as the control loop does, until `enough` holds."""
    end_s = time.monotonic() + 10.0
    while not enough():
        assert time.monotonic() < end_s, f"only {board.heard!r} came"
        robot.apply(twist, turn)
        board.listen(0.01)


def hold_until_later(robot: SerialRobot, board: Board, epoch: int) -> None:
    """Send motion until the epoch is a later one."""
    hold(robot, board, AHEAD, 1, lambda: robot.state().epoch > epoch)


def drives(board: Board, left_mmps: int, right_mmps: int) -> Callable[[], bool]:
    return lambda: board.said(DriveBody(left_mmps, right_mmps))


def ends_with_stops(board: Board) -> bool:
    return board.heard.endswith(b"SSS")


# --- driving ------------------------------------------------------------------------------


def test_frames_come_down_the_line(connect: Callable[..., SerialRobot], board: Board) -> None:
    """It begins with hello, drives and stops as commanded."""
    robot = connect()
    online(robot)
    robot.apply(STANDSTILL, 3)
    hold(robot, board, AHEAD, 3, drives(board, 500, 500))
    robot.stop(3)
    board.until(lambda: board.stands("frames"))
    assert isinstance(board.frames()[0].body, HelloBody)
    assert {f.turn for f in board.frames() if isinstance(f.body, DriveBody)} == {3}


def test_bytes_come_down_the_line(connect: Callable[..., SerialRobot], board: Board) -> None:
    """A motion is one byte (and its speed's), its end three stop bytes, then silence."""
    robot = connect("bytes")
    board.until(lambda: board.heard == b"SSS")
    robot.apply(STANDSTILL, 1)
    hold(robot, board, AHEAD, 1, lambda: board.heard == b"SSS2F")
    robot.apply(AHEAD, 1)
    hold(robot, board, Twist(0.5, 1.2), 1, lambda: board.heard == b"SSS2FG")
    robot.apply(STANDSTILL, 1)
    board.until(lambda: board.heard == b"SSS2FGSSS")
    assert board.listen(0.1) == b""


def test_the_base_is_as_configured(connect: Callable[..., SerialRobot], board: Board) -> None:
    """What is sent follows the configured wheel base, trim and inversion."""
    robot = connect(wheel_base_m=0.4, left_trim=0.5, invert_right=True)
    online(robot)
    robot.apply(STANDSTILL, 1)
    hold(robot, board, Twist(0.3, 0.5), 1, drives(board, 100, -400))


def test_its_axes_are_the_configured_ones(
    connect: Callable[..., SerialRobot], board: Board
) -> None:
    """A configured name moves the axis of its place; without names there is none."""
    robot = connect(serial={"axes": ["pan", "lamp"]})
    assert robot.limits.axes == ("pan", "lamp")
    online(robot)
    robot.set_axis("lamp", 0.5, 1)
    board.until(lambda: board.said(AxisBody(1, 5000)))
    assert SerialRobot(RobotSettings(), SystemClock()).limits.axes == ()


@pytest.mark.alone
@DIALECTS
def test_silence_stops_the_robot(
    connect: Callable[..., SerialRobot], board: Board, dialect: str
) -> None:
    """Without a new set-point for its time-to-live, the driver sends a stop."""
    robot = connect(dialect, serial={"ttl_ms": 200})
    online(robot)
    began_s = 0.0

    def moves() -> bool:
        nonlocal began_s
        if not board.moves(dialect) and time.monotonic() - began_s > 0.2:
            robot.apply(STANDSTILL, 1)
            began_s = time.monotonic()
            robot.apply(AHEAD, 1)
        return board.moves(dialect)

    board.until(moves)
    board.until(lambda: board.stands(dialect))
    assert 0.19 <= time.monotonic() - began_s < 1.0


@DIALECTS
def test_a_lower_turn_reaches_no_wire(
    connect: Callable[..., SerialRobot], board: Board, dialect: str
) -> None:
    """A set-point of an earlier turn is not sent."""
    robot = connect(dialect)
    online(robot)
    robot.stop(9)
    robot.apply(AHEAD, 8)
    board.listen(0.15)
    assert not board.moves(dialect)


@pytest.mark.alone
@DIALECTS
def test_closing_stops_the_robot(
    connect: Callable[..., SerialRobot], board: Board, dialect: str
) -> None:
    """The last thing on the line is a stop, and closing takes less than a second."""
    robot = connect(dialect)
    online(robot)
    robot.apply(STANDSTILL, 1)
    hold(robot, board, AHEAD, 1, lambda: board.moves(dialect))
    start_s = time.monotonic()
    robot.close()
    assert time.monotonic() - start_s < 1.0
    assert not robot.state().connected
    board.until(lambda: board.stands(dialect) if dialect == "frames" else ends_with_stops(board))
    board.listen(0.05)
    assert board.stands(dialect)


def test_a_change_is_written_at_once(
    connect: Callable[..., SerialRobot], board: Board, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A set-point does not wait for the next due time, here a minute later."""
    for due in ("DRIVE_EVERY_S", "STOP_EVERY_S", "SILENT_AFTER_S"):
        monkeypatch.setattr(frames_dialect, due, 60.0)
    robot = connect()
    monkeypatch.setattr(robot._core._setpoints, "_ttl_s", 60.0)
    online(robot)
    robot.apply(STANDSTILL, 1)
    for number in range(1, 51):
        robot.apply(Twist(number / 100, 0.0), 1)
        board.until(drives(board, number * 10, number * 10))


# --- listening ----------------------------------------------------------------------------


def test_reports_are_shown_and_garbage_is_survived(
    connect: Callable[..., SerialRobot], board: Board
) -> None:
    """Among any garbage, reports are decoded and driving continues."""
    robot = connect()
    online(robot)
    board.say(os.urandom(3000) + b"\xa5\x5a\x20" + bytes(60))
    eventually(robot, lambda state: state.extra["line_errors"] > 0)
    epoch = robot.state().epoch
    robot.apply(STANDSTILL, 1)
    hold(robot, board, AHEAD, 1, drives(board, 500, 500))
    eventually(robot, lambda state: state.moving is True)
    assert (robot.state().problem, robot.state().epoch) == (None, epoch)


def test_a_talkative_robot_does_not_delay_commands(
    connect: Callable[..., SerialRobot], board: Board
) -> None:
    """While the robot floods the line, commands still reach it."""
    robot = connect()
    online(robot)
    robot.apply(STANDSTILL, 1)
    stop_flood = threading.Event()
    report = encode(Frame(ReportBody(7400, 0, 0, 0, 0, 0)), NO_SESSION)

    def flood() -> None:
        while not stop_flood.wait(0.001):
            board.say(report * 10)

    thread = threading.Thread(target=flood)
    thread.start()
    try:
        hold(robot, board, AHEAD, 1, drives(board, 500, 500))
    finally:
        stop_flood.set()
        thread.join()


# --- a robot that does not answer -----------------------------------------------------------


@pytest.mark.parametrize("fault", ["mute", "deaf"])
def test_a_robot_that_does_not_answer_differs_from_a_lost_port(
    connect: Callable[..., SerialRobot], board: Board, fault: str
) -> None:
    """A mute or deaf robot is a problem of its own.

    It is greeted until it answers, and stands until there was standstill.
    """
    robot = connect()
    online(robot)
    setattr(board, fault, True)
    eventually(robot, lambda state: not state.connected)
    epoch = robot.state().epoch
    problem = robot.state().problem or ""
    assert f"does not answer on {board.path}" in str(problem)
    assert "server/firmware" in str(problem)
    board.forget()
    setattr(board, fault, False)
    hold(robot, board, AHEAD, 1, lambda: robot.state().connected)
    hold(robot, board, AHEAD, 1, lambda: len(board.frames()) > 5)
    assert robot.state().epoch == epoch + 1
    assert not board.moves("frames")
    assert robot.state().problem is None


def test_a_board_that_restarts_begins_a_new_epoch(
    connect: Callable[..., SerialRobot], board: Board
) -> None:
    """A board that restarts under a held key does not move before standstill."""
    robot = connect()
    online(robot)
    epoch = robot.state().epoch
    robot.apply(STANDSTILL, 1)
    hold(robot, board, AHEAD, 1, lambda: board.core.moving)
    board.restart()
    board.forget()
    hold_until_later(robot, board, epoch)
    board.forget()
    hold(robot, board, AHEAD, 1, lambda: len(board.frames()) > 5)
    assert board.core.wheels_mmps == (0, 0)
    assert not board.moves("frames")


def test_a_program_of_another_kind_does_not_answer(
    connect: Callable[..., SerialRobot], board: Board
) -> None:
    """Without the firmware's answer only hello and stop are sent."""
    board.mute = True
    robot = connect()
    eventually(robot, lambda state: state.problem is not None)
    robot.apply(STANDSTILL, 1)
    robot.apply(AHEAD, 1)
    board.listen(0.3)
    assert {type(frame.body) for frame in board.frames()} == {HelloBody, StopBody}
    assert not robot.state().connected


def test_drives_come_without_a_gap(connect: Callable[..., SerialRobot], board: Board) -> None:
    """A held motion is repeated, no more often than fifty times a second.

    The times are the sender's; a busy machine may be late, but not so late that the board stops.
    """
    robot = connect()
    online(robot)
    robot.apply(STANDSTILL, 1)
    board.forget()
    epoch = robot.state().epoch
    hold(robot, board, AHEAD, 1, lambda: len(board.frames()) > 60)
    times_ms = [frame.time_ms for frame in board.frames() if isinstance(frame.body, DriveBody)]
    gaps_ms = sorted(after - before for before, after in itertools.pairwise(times_ms))
    assert gaps_ms[len(gaps_ms) // 2] >= 19
    assert robot.state().epoch == epoch


# --- losing the line ----------------------------------------------------------------------


@pytest.mark.alone
@DIALECTS
def test_a_pulled_plug_is_noticed(
    connect: Callable[..., SerialRobot], board: Board, dialect: str
) -> None:
    """Within 0.5 s of the loss the state has a problem."""
    robot = connect(dialect)
    online(robot)
    board.unplug()
    took_s = eventually(robot, lambda state: not state.connected)
    assert took_s < 0.5
    problem = str(robot.state().said)
    assert str(board.path) in problem
    assert problem[0].isupper()
    assert problem.endswith(".")


@pytest.mark.alone
@DIALECTS
def test_nothing_moves_after_a_loss_without_a_new_command(
    connect: Callable[..., SerialRobot], board: Board, dialect: str
) -> None:
    """None of twenty losses under a held key ends in motion before the key is released."""
    robot = connect(dialect)
    for round_number in range(20):
        online(robot)
        epoch = robot.state().epoch
        robot.apply(STANDSTILL, 1)
        hold(robot, board, AHEAD, 1, lambda: board.moves(dialect))
        board.unplug()
        eventually(robot, lambda state: not state.connected)
        board.plug()
        hold_until_later(robot, board, epoch)
        for _ in range(10):
            robot.apply(AHEAD, 1)
            board.listen(0.01)
        assert board.heard
        assert not board.moves(dialect), round_number


@DIALECTS
def test_a_missing_port_is_awaited(
    connect: Callable[..., SerialRobot], board: Board, dialect: str
) -> None:
    """A missing port is a problem that says what to do; it is used as soon as it exists."""
    board.unplug()
    robot = connect(dialect)
    eventually(robot, lambda state: state.problem is not None)
    assert "wax devices" in str(robot.state().problem)
    board.plug()
    online(robot)
    assert robot.state().problem is None


def test_a_port_in_use_is_a_problem(connect: Callable[..., SerialRobot], board: Board) -> None:
    """A second program on the same port is refused with a reason."""
    online(connect())
    second = connect()
    eventually(second, lambda state: state.problem is not None)
    assert "Another program" in str(second.state().problem)


@pytest.mark.parametrize(
    "url", ["nonsense://x", "socket://localhost", "rfc2217://127.0.0.1:1", "/dev/null", "/"]
)
def test_no_address_breaks_the_driver(
    connect: Callable[..., SerialRobot], board: Board, url: str
) -> None:
    """An address that is no serial port is a problem, and is retried for ever."""
    robot = connect(serial={"url": url, "reopen_s": 0.05})
    eventually(robot, lambda state: state.problem is not None)
    assert url in str(robot.state().problem)
    robot.apply(AHEAD, 1)
    robot.stop(1)


@pytest.mark.filterwarnings(
    # pyserial leaves a socket that the far end has reset to the garbage collector
    "ignore:Exception ignored in. <socket:pytest.PytestUnraisableExceptionWarning"
)
@pytest.mark.alone
def test_a_line_over_the_network(connect: Callable[..., SerialRobot]) -> None:
    """A robot at a TCP address is driven like one on a cable, and its loss is detected."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        robot = connect(serial={"url": f"socket://127.0.0.1:{server.getsockname()[1]}"})
        far_end, _ = server.accept()
        with far_end:
            core = Core(now_ms=_now_ms())
            while core.wheels_mmps == (0, 0):
                now_ms = _now_ms()
                core.hear(far_end.recv(100), now_ms)
                core.tick(now_ms)
                far_end.sendall(core.report(now_ms))
                if robot.state().connected:
                    robot.apply(STANDSTILL, 1)
                    robot.apply(AHEAD, 1)
        assert eventually(robot, lambda state: not state.connected) < 0.5


def test_a_loop_is_a_line(connect: Callable[..., SerialRobot]) -> None:
    """Pyserial's loop, which has no descriptor to wait on, is read and closed like others.

    The server's own echoed frames do not count as an answer.
    """
    robot = connect(serial={"url": "loop://"})
    eventually(robot, lambda state: state.problem is not None)
    assert "does not answer on loop://" in str(robot.state().problem)
    assert robot.state().extra["line_errors"] == 0.0
    start_s = time.monotonic()
    robot.close()
    assert time.monotonic() - start_s < 1.0


@DIALECTS
def test_a_line_that_only_fails_to_read_ends_with_a_stop(
    connect: Callable[..., SerialRobot],
    board: Board,
    dialect: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """If reading fails while writing still works, a stop is sent before closing."""
    robot = connect(dialect, serial={"reopen_s": 30.0})
    online(robot)
    robot.apply(STANDSTILL, 1)
    hold(robot, board, AHEAD, 1, lambda: board.moves(dialect))

    def fail(port: serial.Serial, size: int = 1) -> bytes:
        raise serial.SerialException("device reports readiness to read but returned no data")

    robot.apply(AHEAD, 1)
    monkeypatch.setattr(serial.Serial, "read", fail)
    lasts_s = PATIENT_MS / 1000
    board.until(lambda: board.stands(dialect), within_s=0.8 * lasts_s)  # before it expires
    eventually(robot, lambda state: not state.connected)
    assert dialect == "frames" or ends_with_stops(board)
    assert "no data" in str(robot.state().problem)


class Flood:
    """A conversation that only sends motion, faster than any board reads it."""

    def __init__(self) -> None:
        self.problem: Sentence | None = None

    def hello(self, now_s: float) -> bytes:
        return b""

    def next(self, now_s: float) -> tuple[bytes, float]:
        return b"F" * 1000, now_s

    def received(self, data: bytes, now_s: float) -> None: ...

    def farewell(self) -> bytes:
        return b"SSS"

    def lost(self, problem: Sentence | None) -> None:
        self.problem = problem or self.problem


@pytest.mark.alone
def test_a_clogged_line_ends_with_a_stop(board: Board) -> None:
    """If a board reads nothing for too long, a stop replaces what is still in the buffer."""
    board.deaf = True
    settings, flood = SerialSettings(url=str(board.path), reopen_s=30.0), Flood()
    line = PortLine(settings, SystemClock(), flood)
    kept = KeptLine("flood", line, flood, SystemClock(), reopen_s=30.0)
    kept.open()
    board.until(lambda: flood.problem is not None)
    kept.close()
    assert "Write timeout" in str(flood.problem)
    assert not hasattr(line, "_port")
    board.deaf = False
    board.until(lambda: ends_with_stops(board))


@pytest.mark.alone
def test_a_board_that_takes_nothing_is_a_lost_one(
    connect: Callable[..., SerialRobot], board: Board
) -> None:
    """If nobody reads, writing does not block the callers, and closing takes less than 1 s."""
    robot = connect(serial={"axes": ["pan"], "ttl_ms": 20, "reopen_s": 5.0})
    online(robot)
    board.deaf = True
    start_s = time.monotonic()
    number = 0
    while robot.state().connected:
        number += 1
        robot.set_axis("pan", 0.001 * (number % 500), number)
        assert time.monotonic() - start_s < 20.0
    assert robot.state().problem is not None
    start_s = time.monotonic()
    robot.close()
    assert time.monotonic() - start_s < 1.0
