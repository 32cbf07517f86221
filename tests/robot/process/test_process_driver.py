"""The server's end of the driver process, and the process that it restarts."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from typing import TYPE_CHECKING, Any

import pytest
from tests.real_time import may_run_in_real_time
from tests.robot.process.conftest import Log, is_alive, settings_for
from tests.robot.process.parent import process_driver
from tests.until import until

from wax.clock import SystemClock
from wax.config.controls import ControlSettings
from wax.config.log import LogSettings
from wax.driver.checks import NO_ANSWER
from wax.driver.interface import STANDSTILL, Limits, Twist
from wax.robot.process import driver as driver_module
from wax.robot.process.child_process import ChildProcess
from wax.robot.process.driver import ProcessDriver
from wax.robot.process.pipe_messages import (
    Begin,
    LineBuffer,
    Move,
    StateReport,
    decode_answer,
    encode,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from wax.driver.interface import Driver

pytestmark = pytest.mark.system

AHEAD = Twist(0.5, 0.0)


@pytest.fixture
def made(log: Log) -> Iterator[Callable[..., ProcessDriver]]:
    """Make the robot of this name, opened; it is closed after the test."""
    robots: list[ProcessDriver] = []

    def make(name: str, **more: Any) -> ProcessDriver:
        robots.append(process_driver(settings_for(log, name), **more))
        robots[-1].open()
        return robots[-1]

    yield make
    for robot in robots:
        robot.close()


@pytest.fixture
def robot(made: Callable[..., Driver]) -> Driver:
    """Open a robot, which is connected."""
    robot = made("Recorder")
    until(lambda: robot.state().connected)
    return robot


def drives(robot: Driver, log: Log, twist: Twist = AHEAD, during_s: float = 0.3) -> bool:
    """Ask for motion for a while, as the control loop does, and tell whether it moved."""
    since_s = time.monotonic()
    while time.monotonic() < since_s + during_s and not log.moves(since_s):
        robot.apply(twist, 1)
        time.sleep(0.02)
    return log.moves(since_s)


def drive_off(robot: Driver, log: Log, twist: Twist = AHEAD) -> None:
    """Drive, with standstill first; on a busy machine the server may be silent for too long."""

    def drives_off() -> bool:
        robot.apply(STANDSTILL, 1)
        return drives(robot, log, twist)

    until(drives_off)


def test_state_and_axes_come_through(robot: Driver, log: Log) -> None:
    """State and axes pass through the pipe; printed output does not."""
    state = robot.state()
    assert state.extra["battery_v"] == 7.4
    assert (state.problem, state.epoch, state.moving) == (None, 1, None)
    assert state.extra["driver_garbled"] == 0

    def moved() -> set[tuple[float, ...]]:
        robot.apply(STANDSTILL, 1)
        robot.set_axis("tilt", 0.5, 1)
        robot.set_axis("pan", 7.0, 1)
        return {entry.values for entry in log.entries() if entry.word == "axis"}

    until(lambda: moved() != set())
    assert moved() == {(1.0, 1.0)}


def test_silence_is_told_and_ends_with_standstill(robot: Driver, log: Log) -> None:
    """Silence stops the robot, with a problem and a new epoch for the server."""
    before = robot.state()
    drive_off(robot, log)
    until(lambda: robot.state().problem is not None)
    state = robot.state()
    assert "silent" in str(state.problem)
    assert state.epoch > before.epoch
    assert state.extra["driver_silences"] > before.extra["driver_silences"]
    assert not drives(robot, log)

    def is_mended() -> bool:
        robot.apply(STANDSTILL, 1)  # a busy machine may have been silent for too long once more
        return robot.state().problem is None

    until(is_mended)
    drive_off(robot, log)


def test_a_set_point_is_no_faster_than_configured(log: Log) -> None:
    """Each part comes through, on a curve that is slowed as a whole to what `[robot]` allows."""
    slow = {"max_linear_mps": 0.4, "max_lateral_mps": 0.3}
    robot = process_driver(settings_for(log).model_copy(update=slow))
    robot.open()
    drive_off(robot, log, Twist(0.48, 1.0, -0.48))
    told = {tuple(round(v, 6) for v in one.values) for one in log.entries() if one.is_motion}
    assert told == {(0.24, 0.5, -0.24, 1.0)}
    robot.close()


def test_a_killed_process_is_started_again(robot: Driver, log: Log) -> None:
    """A killed process is reported at once and restarted, and nothing moves before standstill.

    The counts outlive the process.
    """
    drive_off(robot, log)
    until(lambda: robot.state().problem is not None)  # the server is silent
    drive_off(robot, log)
    killed, epoch = log.pid(), robot.state().epoch
    assert robot.state().extra["driver_pid"] == killed
    os.kill(killed, signal.SIGKILL)
    until(lambda: not robot.state().connected)
    assert "has ended (signal 9); restarting it." in str(robot.state().problem)
    killed_s = time.monotonic()
    silences = robot.state().extra["driver_silences"]
    assert silences > 0
    until(lambda: robot.state().extra["driver_restarts"] == 1)
    assert robot.state().extra["driver_silences"] == silences
    until(lambda: drives(robot, log, during_s=0.1) or robot.state().connected)
    until(lambda: drives(robot, log) or robot.state().extra["driver_unarmed"] > 0)
    assert not log.moves(killed_s)
    state = robot.state()
    assert state.epoch > epoch
    assert state.extra["driver_restarts"] == 1
    assert state.extra["driver_silences"] >= silences
    assert log.pid() != killed
    drive_off(robot, log)


def test_a_frozen_process_is_replaced(robot: Driver, log: Log) -> None:
    """A process that is silent for a second is killed and replaced."""
    frozen = log.pid()
    os.kill(frozen, signal.SIGSTOP)
    until(lambda: not robot.state().connected)
    assert "does not answer; restarting it." in str(robot.state().problem)
    until(lambda: robot.state().connected)
    assert log.pid() != frozen
    assert not is_alive(frozen)


def test_a_process_that_does_not_read_is_ended(
    made: Callable[..., Driver], log: Log, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A process that does not read its full pipe is killed, so that the robot's watchdog acts."""
    monkeypatch.setattr(driver_module, "HUNG_S", 60.0)  # it is not ended as one that is frozen
    robot = made("Recorder")
    until(lambda: robot.state().connected)
    frozen = log.pid()
    os.kill(frozen, signal.SIGSTOP)
    took_s = []
    while robot.state().extra["driver_full"] == 0:
        start_s = time.monotonic()
        robot.stop(1)
        took_s.append(time.monotonic() - start_s)
    assert sorted(took_s)[len(took_s) // 2] < 0.005
    until(lambda: not is_alive(frozen))


@pytest.mark.alone
def test_what_waited_in_the_pipe_moves_nothing(robot: Driver, log: Log) -> None:
    """After a freeze of the process its backlog moves nothing, whether old or fresh.

    Its next driver call stops the robot. Only a call that the freeze has interrupted, after the
    last check of the clock, comes before that.
    """
    drive_off(robot, log)
    os.kill(log.pid(), signal.SIGSTOP)
    assert not drives(robot, log)
    going_s = time.monotonic()
    os.kill(log.pid(), signal.SIGCONT)
    drives(robot, log)
    assert log.stopped_s(going_s) - going_s < 0.2
    told = log.entries(going_s)
    cut = 1 if told[0].is_motion else 0
    assert told[cut].word == "stop"
    assert not any(entry.is_motion for entry in told[cut:])
    assert not drives(robot, log)
    drive_off(robot, log)


def test_the_process_ignores_what_a_terminal_sends(robot: Driver, log: Log) -> None:
    """SIGINT, SIGHUP and SIGTERM do not end the process before the server."""
    for number in (signal.SIGINT, signal.SIGHUP, signal.SIGTERM):
        os.kill(log.pid(), number)
    assert not drives(robot, log, STANDSTILL)
    drive_off(robot, log)
    assert robot.state().extra["driver_restarts"] == 0


def test_set_points_come_steadily(robot: Driver, log: Log) -> None:
    """A robot gets more set-points than a server sends that sends fewer than 50 a second.

    `test_child_loop` tests how many, on a clock turned by hand.
    """
    since_s = time.monotonic()
    said = 0

    def hears_more() -> bool:
        nonlocal said
        robot.apply(STANDSTILL, 1)
        said += 1
        time.sleep(0.07)
        return sum(entry.word == "apply" for entry in log.entries(since_s)) >= 2 * said + 3

    until(hears_more)


def test_a_driver_that_raises_is_stopped(made: Callable[..., Driver], log: Log) -> None:
    """A driver that raises is stopped, reported as not answering, and works after standstill."""
    robot = made("Fragile")
    until(lambda: robot.state().connected)
    drive_off(robot, log)
    since_s = time.monotonic()

    def fails() -> bool:
        robot.apply(STANDSTILL, 1)  # a busy machine may have been silent for too long
        robot.apply(Twist(0.1, 0.1), 1)
        time.sleep(0.1)
        return robot.state().problem == NO_ANSWER

    until(fails)
    assert robot.state().extra["driver_failures"] >= 1
    assert log.stopped_s(since_s)
    assert not drives(robot, log)
    drive_off(robot, log)


def test_a_driver_that_tells_nonsense_does_not_answer(made: Callable[..., Driver]) -> None:
    """An invalid state counts as no answer; the process keeps running."""
    robot = made("Liar")
    until(lambda: robot.state().problem == NO_ANSWER)
    assert not robot.state().connected
    assert robot.state().extra["driver_restarts"] == 0


def test_it_goes_before_others_where_it_may(robot: Driver) -> None:
    if not may_run_in_real_time():
        pytest.skip("this user may not run in real time")
    assert os.sched_getscheduler(int(robot.state().extra["driver_pid"])) == os.SCHED_RR


@pytest.mark.alone
def test_a_driver_that_cannot_be_closed_is_ended(made: Callable[..., Driver], log: Log) -> None:
    """A driver that hangs in `close` is killed within a second, after the robot was stopped."""
    robot = made("Stuck")
    until(lambda: robot.state().connected)
    start_s = time.monotonic()
    robot.close()
    assert time.monotonic() - start_s < 1.0
    assert [entry.word for entry in log.entries()][-2:] == ["stop", "close"]
    until(lambda: not is_alive(log.pid()))
    assert not robot.state().connected


def test_a_silent_server_lets_go_of_what_it_held(
    made: Callable[..., ProcessDriver], log: Log
) -> None:
    """Through the real pipe, a horn and a motion begin, and end when the server falls silent."""
    controls = [
        ControlSettings(name="horn", kind="button"),
        ControlSettings(name="spin", kind="button", moves=True),
    ]
    robot = made("Equipped", controls=controls)
    until(lambda: robot.state().connected)

    def told(name: str) -> list[tuple[float, ...]]:
        return [entry.values for entry in log.entries() if entry.word == name]

    def begins() -> bool:
        robot.apply(STANDSTILL, 1)
        robot.control("horn", True, 1)
        robot.control("spin", True, 1)
        robot.control("lamp", True, 1)  # which it does not have
        time.sleep(0.02)
        return (1.0, 1.0) in told("spin")

    until(begins)
    until(lambda: told("spin")[-1] == told("horn")[-1] == (0.0, 1.0))
    assert told("lamp") == []
    until(lambda: "silent" in str(robot.state().problem))


def test_it_may_be_closed_while_it_begins(made: Callable[..., Driver]) -> None:
    """A process can be closed while it starts, and opened again."""
    robot = made("Recorder")
    robot.close()
    robot.close()
    assert robot.state().problem is None
    robot.open()
    until(lambda: robot.state().connected)


def test_another_robot_than_was_asked_is_not_driven(log: Log) -> None:
    """A robot whose limits differ from those that the server knows is not driven."""
    robot = ProcessDriver(
        settings_for(log), SystemClock(), kind="recorder", limits=Limits(0.3, 1.5)
    )
    robot.open()
    until(lambda: robot.state().problem is not None)
    assert "restart WAX" in str(robot.state().problem)
    assert not robot.state().connected
    robot.close()


def test_a_process_that_cannot_begin_says_so(log: Log) -> None:
    """A process whose driver cannot be built ends with a reason, and is restarted."""
    settings = settings_for(log).model_copy(update={"driver": "no.such:Robot"})
    robot = ProcessDriver(settings, SystemClock(), kind="recorder", limits=Limits(0.6, 1.5))
    robot.open()
    until(lambda: robot.state().extra["driver_restarts"] >= 2)
    assert "cannot be loaded; retrying. robot.driver: no.such:Robot" in str(robot.state().problem)
    robot.close()


def test_garbage_on_the_pipe_stops_the_robot(log: Log) -> None:
    """An invalid message is counted and holds the robot until standstill is requested."""
    child = ChildProcess(encode(Begin(robot=settings_for(log), log=LogSettings())))
    clock = SystemClock()
    lines = LineBuffer()
    number = 0

    def say(linear: float) -> None:
        nonlocal number
        number += 1
        child.send(
            encode(
                Move(
                    sequence=number,
                    sent_s=clock.now_s(),
                    turn=1,
                    linear_mps=linear,
                    angular_rps=0.0,
                )
            )
        )

    def moves_off() -> bool:
        say(0.0)
        return moves()

    def moves() -> bool:
        since_s = time.monotonic()
        while time.monotonic() < since_s + 0.15:
            say(0.5)
            time.sleep(0.02)
        return log.moves(since_s)

    def counted() -> int:
        answers = [decode_answer(line) for line in lines.feed(child.receive(1.0) or b"")]
        return max(
            [a.counts["driver_garbage"] for a in answers if isinstance(a, StateReport)] or [0]
        )

    until(lambda: bool(log.entries()))
    for nonsense in (b"garbage\n", b"\xff\x00\n", b'{"say":"move"}\n', b"[" * 200_000 + b"\n"):
        until(moves_off)
        since_s = time.monotonic()
        rest = nonsense
        while rest:
            child.send(rest[:4096])
            rest = rest[4096:]
            time.sleep(0.001)
        log.stopped_s(since_s)
        assert not moves()
    until(lambda: counted() == 4)
    assert child.end() == 0


def test_the_process_loads_nothing_that_it_does_not_need() -> None:
    """The driver process loads no media libraries, which would delay a restart."""
    heavy = ("cv2", "av", "aiortc", "aiohttp", "numpy", "sounddevice")
    asked = (
        f"import sys, wax.robot.process.__main__; print([n for n in {heavy} if n in sys.modules])"
    )
    said = subprocess.run([sys.executable, "-c", asked], capture_output=True, check=True, text=True)
    assert said.stdout == "[]\n"
