"""Two servers for one robot: one has it, the other says so and moves nothing."""

from __future__ import annotations

import os
import time
from typing import TYPE_CHECKING

import pytest
from tests.robot.process.conftest import Log, settings_for
from tests.robot.process.recorder import Recorder
from tests.until import until

from wax.clock import SystemClock
from wax.config.robot import RobotSettings
from wax.driver.interface import STANDSTILL, Limits, Twist
from wax.robot.build_driver import limits_of
from wax.robot.process.driver import ProcessDriver
from wax.robot.process.robot_lock import RobotLock

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from tests.robot.conftest import Board

TAKEN = "Another server on this machine has this robot: end that one first."


def test_a_robot_is_locked_once() -> None:
    """Another robot has its own lock; one that is released is free."""
    mine, others = (
        RobotSettings.model_validate({"boat": {"sail": sail, "of": os.getpid()}}) for sail in (1, 2)
    )
    first, second, other = RobotLock(mine), RobotLock(mine), RobotLock(others)
    try:
        assert first.acquire()
        assert first.acquire()
        assert not second.acquire()
        assert other.acquire()
        first.release()
        first.release()
        assert second.acquire()
        assert not first.acquire()
    finally:
        for lock in (first, second, other):
            lock.release()


@pytest.fixture
def made() -> Iterator[Callable[[RobotSettings, str, Limits], ProcessDriver]]:
    """Make an opened robot; it is closed after the test."""
    robots: list[ProcessDriver] = []

    def make(settings: RobotSettings, kind: str, limits: Limits) -> ProcessDriver:
        robots.append(ProcessDriver(settings, SystemClock(), kind=kind, limits=limits))
        robots[-1].open()
        return robots[-1]

    yield make
    for robot in robots:
        robot.close()


@pytest.mark.system
def test_the_second_server_waits_and_moves_nothing(
    made: Callable[[RobotSettings, str, Limits], ProcessDriver], log: Log
) -> None:
    """The second server does not open the robot until the first has released it."""
    settings = settings_for(log)
    limits = limits_of(Recorder(settings, SystemClock()), settings)
    first = made(settings, "recorder", limits)
    until(lambda: first.state().connected)
    second = made(settings, "recorder", limits)
    until(lambda: str(second.state().problem) == TAKEN)

    def drives() -> bool:
        for twist in (STANDSTILL, Twist(0.5, 0.0), Twist(0.5, 0.0)):
            first.apply(twist, 1)
            second.apply(Twist(-0.5, 0.0), 9)
            time.sleep(0.02)
        return log.moves()

    until(drives)
    assert not second.state().connected
    assert [entry.word for entry in log.entries()].count("open") == 1
    assert all(entry.values[0] >= 0.0 for entry in log.entries() if entry.word == "apply")
    first.close()
    until(lambda: second.state().connected)
    assert [entry.word for entry in log.entries()].count("open") == 2
    assert second.state().problem is None


@pytest.mark.system
def test_a_serial_port_is_not_shared_by_another_name(
    made: Callable[[RobotSettings, str, Limits], ProcessDriver], board: Board
) -> None:
    """The system refuses the port to a second server that uses another name for it."""
    limits = Limits(0.6, 1.5, ttl_s=0.2)

    def settings(url: str) -> RobotSettings:
        return RobotSettings.model_validate(
            {"driver": "serial", "serial": {"url": url, "reopen_s": 0.05}}
        )

    first = made(settings(str(board.path)), "serial", limits)
    until(lambda: first.state().connected)
    other = board.path.with_name("the same")
    other.symlink_to(board.path.readlink())
    second = made(settings(str(other)), "serial", limits)
    until(lambda: "Another program is using" in str(second.state().problem))
    second.apply(STANDSTILL, 1)
    second.apply(Twist(0.5, 0.0), 1)
    time.sleep(0.3)
    board.listen(0.05)
    assert not board.moves("frames")
    assert first.state().connected
