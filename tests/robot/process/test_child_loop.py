"""What the driver process does when its server is gone, call by call."""

from __future__ import annotations

import contextlib
import os
import select
import signal
from typing import TYPE_CHECKING

import pytest
from tests.idle_robot import IdleRobot

from wax.config.controls import ControlSettings
from wax.config.local import LocalSettings
from wax.config.robot import RobotSettings
from wax.driver.hand import HandReading
from wax.driver.interface import Limits, RobotState, Twist
from wax.robot.process.child_loop import ChildLoop
from wax.robot.process.driver_watchdog import DriverWatchdog
from wax.robot.process.passenger import Passenger, hand_watchdog
from wax.robot.process.passenger_claim import Claim
from wax.robot.process.pipe_messages import Bye, Control, Move, encode

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from wax.driver.interface import ControlValue

SILENCE_S = 0.12
LIMITS = Limits(0.6, 1.5, ttl_s=0.2)
END_AT = 20
"""The server closes the pipe at this reading of the clock."""
LOCAL = LocalSettings(source="robot", pause_s=0.5)


class Time:
    """A clock that advances by `step_s` each time it is read."""

    def __init__(self) -> None:
        self.time_s = 100.0
        self.step_s = 0.005
        self.looks = 0
        self.each_look: Callable[[], None] = lambda: None

    def now_s(self) -> float:
        self.looks += 1
        self.each_look()
        self.time_s += self.step_s
        return self.time_s

    def wall_ms(self) -> int:
        return 0


class Robot(IdleRobot):
    """Records its calls; its hand control is at rest."""

    limits = LIMITS

    def __init__(self) -> None:
        self.told: list[str] = []
        self.looks = 0
        self.each_look: Callable[[], None] = lambda: None

    def open(self) -> None:
        self.told.append("open")

    def apply(self, twist: Twist, turn: int) -> None:
        self.told.append("stand" if twist.is_zero else "drive")

    def stop(self, turn: int) -> None:
        self.told.append("stop")

    def close(self) -> None:
        self.told.append("close")

    def state(self) -> RobotState:
        self.looks += 1
        self.told.append("state")
        self.each_look()
        return RobotState(connected=True, epoch=1)


class RestingHand:
    """A control that nobody touches."""

    wakes: int | None = None

    def __init__(self, time: Time) -> None:
        self._time = time

    def open(self) -> None: ...

    def take(self) -> tuple[HandReading, ...]:
        return (HandReading(self._time.time_s),)

    def close(self) -> None: ...


class Server:
    """Writes set-points into the pipe, then dies or sends `Bye`."""

    def __init__(self, time: Time) -> None:
        self._time = time
        self.reader, self._writer = os.pipe()
        self.answers, self.writer = os.pipe()
        for end in (self.answers, self.writer):
            os.set_blocking(end, False)
        self._sequence = 0

    def asks(self, *speeds_mps: float) -> None:
        for speed_mps in speeds_mps:
            self._sequence += 1
            move = Move(
                sequence=self._sequence,
                sent_s=self._time.time_s,
                turn=1,
                linear_mps=speed_mps,
                angular_rps=0.0,
            )
            os.write(self._writer, encode(move))

    def sets(self, name: str, *, on: bool) -> None:
        self._sequence += 1
        told = Control(
            sequence=self._sequence, sent_s=self._time.time_s, turn=1, name=name, value=on
        )
        os.write(self._writer, encode(told))

    def says_goodbye(self) -> None:
        os.write(self._writer, encode(Bye()))

    def listens(self) -> None:
        with contextlib.suppress(BlockingIOError):
            os.read(self.answers, 65_536)

    def dies(self) -> None:
        os.close(self._writer)

    def end(self) -> None:
        for end in (self.reader, self.answers, self.writer):
            os.close(end)


@pytest.fixture
def time() -> Time:
    return Time()


@pytest.fixture
def server(time: Time, monkeypatch: pytest.MonkeyPatch) -> Iterator[Server]:
    # Its alarm is for a process of its own: here it would end the tests.
    monkeypatch.setattr(signal, "setitimer", lambda *_: None)
    server = Server(time)
    yield server
    server.end()


def test_without_a_person_aboard_the_end_of_the_pipe_is_the_end(time: Time, server: Server) -> None:
    """Without a person aboard, the pipe's end stops and closes the robot at once."""
    time.step_s = 0.02  # a beat is due in every round
    robot = Robot()
    watchdog = DriverWatchdog(LIMITS, 10.0)
    loop = ChildLoop(robot, watchdog, time, reader=server.reader, writer=server.writer)

    def each_look() -> None:
        if robot.looks == 4:
            server.asks(0.0, 0.3)
        elif robot.looks == 8:
            server.dies()

    robot.each_look = each_look
    loop.run()
    assert "drive" in robot.told
    assert robot.told[-4:] == ["state", "state", "stop", "close"]


def test_a_set_point_is_repeated_fifty_times_a_second(
    time: Time, server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Set-points are repeated fifty times a second, however seldom the server sends one."""
    time.step_s = 0.0
    at_once = select.select

    def passes(readers: list[int], _w: object, _x: object, pause_s: float) -> object:
        time.time_s += pause_s
        return at_once(readers, [], [], 0.0)

    monkeypatch.setattr(select, "select", passes)
    beats_s: list[float] = []

    class Timed(Robot):
        def apply(self, twist: Twist, turn: int) -> None:
            beats_s.append(time.time_s)

    robot = Timed()
    watchdog = DriverWatchdog(LIMITS, 10.0)
    loop = ChildLoop(robot, watchdog, time, reader=server.reader, writer=server.writer)

    def each_look() -> None:
        server.listens()
        if len(beats_s) == 51 and robot.each_look is each_look:
            robot.each_look = lambda: None
            server.dies()

    robot.each_look = each_look
    loop.run()
    assert beats_s[50] - beats_s[0] == pytest.approx(1.0)


class Spinning(Robot):
    """Has a control that moves."""

    def control(self, name: str, value: ControlValue, turn: int) -> None:
        self.told.append("drive" if value else "let go")


def frozen(at_look: int) -> tuple[list[str], list[str]]:
    """Drive, and freeze just before that reading of the clock; return the calls before and after.

    The server keeps running, and its messages before, during and after the freeze are all fresh.
    """
    time, robot = Time(), Spinning()
    time.step_s = 0.001
    server = Server(time)
    spin = ControlSettings(name="spin", kind="button", moves=True)
    watchdog = DriverWatchdog(LIMITS, SILENCE_S, [spin])
    loop = ChildLoop(robot, watchdog, time, reader=server.reader, writer=server.writer)
    said_before: list[str] = []

    def on_the_clock() -> None:
        if time.looks == at_look:
            time.time_s += 1.0
            said_before.extend(robot.told)
            if robot.looks < END_AT:
                server.asks(0.3)

    def each_look() -> None:
        server.listens()
        if robot.looks < END_AT:
            server.asks(0.0 if robot.looks < 4 else 0.3)
            server.sets("spin", on=robot.looks % 4 < 2)
        elif robot.looks == END_AT:
            server.dies()

    time.each_look, robot.each_look = on_the_clock, each_look
    loop.run()
    server.end()
    return said_before, robot.told[len(said_before) :]


def test_wherever_it_was_frozen_it_stops_before_it_moves(server: Server) -> None:
    """After a freeze at any point the robot is stopped before it moves."""
    del server  # only its quiet alarm is needed
    drove = 0
    for at_look in range(1, 200):
        before, after = frozen(at_look)
        if "drive" in before and after:
            drove += 1
            assert "stop" in after
            assert "drive" not in after
    assert drove > 50


class BrokenLamp(Robot):
    """A robot whose lamp is unplugged."""

    def control(self, name: str, value: ControlValue, turn: int) -> None:
        self.told.append(name)
        raise OSError("no such device")


def test_a_lamp_that_fails_does_not_hold_the_robot(time: Time, server: Server) -> None:
    """A failing lamp does not hold the robot."""
    robot = BrokenLamp()
    lamp = ControlSettings(name="lamp", kind="toggle")
    watchdog = DriverWatchdog(LIMITS, 10.0, [lamp])
    loop = ChildLoop(robot, watchdog, time, reader=server.reader, writer=server.writer)

    def each_look() -> None:
        if robot.looks == 4:
            server.asks(0.0, 0.3)
        elif robot.looks == 6:
            server.sets("lamp", on=True)
        elif robot.looks == 8:
            server.asks(0.3)
        elif robot.looks == 12:
            server.dies()

    robot.each_look = each_look
    loop.run()
    after = robot.told[robot.told.index("lamp") :]
    assert "drive" in after[: after.index("stop")]


@pytest.mark.parametrize("goodbye", [True, False])
def test_with_a_person_aboard_a_dead_server_stops_the_robot_at_once(
    time: Time, server: Server, tmp_path: Path, goodbye: bool
) -> None:
    """With a person aboard a dead server stops the robot at once, but the process keeps running."""
    robot = Robot()
    claim = Claim(tmp_path / "claim")
    watchdog = DriverWatchdog(LIMITS, 1000.0)  # that much silence never comes here
    passenger = Passenger(
        RestingHand(time), hand_watchdog(LOCAL, RobotSettings(), watchdog), time, claim
    )
    loop = ChildLoop(
        robot, watchdog, time, reader=server.reader, writer=server.writer, passenger=passenger
    )
    gone_at: list[int] = []

    def each_look() -> None:
        server.listens()
        if robot.looks == 100:
            server.asks(0.0, 0.3)
        elif robot.looks == 110:
            if goodbye:
                server.says_goodbye()
            server.dies()
            gone_at.append(len(robot.told))
        elif robot.looks == 200:
            Claim(tmp_path / "claim").take()

    robot.each_look = each_look
    server.asks(0.0)
    loop.run()
    after = robot.told[gone_at[0] :]
    assert "drive" in robot.told[: gone_at[0]]
    assert "drive" not in after[after.index("stop") :]
    assert after.index("stop") < 8
    assert robot.told[-1] == "close"
    assert (robot.looks > 150) is not goodbye
