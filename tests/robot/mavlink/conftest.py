"""A driver for MAVLink and rovers to drive."""

from __future__ import annotations

import socket
import time
from typing import TYPE_CHECKING, Any

import pytest
from tests.free_port import free_port
from tests.robot.mavlink.counterpart import Rover

from wax.clock import SystemClock
from wax.config.robot import RobotSettings
from wax.driver.interface import STANDSTILL, Twist
from wax.robot.find_driver import make_driver

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from wax.driver.interface import Driver, RobotState


def settings(**mavlink: Any) -> RobotSettings:
    return RobotSettings.model_validate(
        {"driver": "mavlink", "mavlink": {"reopen_s": 0.05} | mavlink}
    )


class Rig:
    """Both ends of a line: makes drivers and rovers, and closes them after the test."""

    def __init__(self) -> None:
        self.port = free_port(socket.SOCK_DGRAM)
        self.here, self.there = f"udpin:127.0.0.1:{self.port}", f"udpout:127.0.0.1:{self.port}"
        self._all: list[Driver | Rover] = []

    def rover(self, **options: Any) -> Rover:
        """Start a rover, by default in GUIDED and armed."""
        usual: dict[str, Any] = {"address": self.there, "mode": "guided", "armed": True}
        rover = Rover(**usual | options)
        self._all.append(rover)
        return rover

    def driver(self, **mavlink: Any) -> Driver:
        """Make and open a driver."""
        driver = make_driver(settings(**({"url": self.here} | mavlink)), SystemClock())
        self._all.append(driver)
        driver.open()
        return driver

    def close(self) -> None:
        for one in self._all:
            one.close()


@pytest.fixture
def rig() -> Iterator[Rig]:
    rig = Rig()
    yield rig
    rig.close()


def until(driver: Driver, so: Callable[[RobotState], bool], within_s: float = 10.0) -> RobotState:
    end_s = time.monotonic() + within_s
    while not so(state := driver.state()):
        assert time.monotonic() < end_s, state
        time.sleep(0.002)
    return state


def problem(driver: Driver, code: str) -> str:
    """Wait for this problem; return its sentence."""
    state = until(driver, lambda state: getattr(state.problem, "code", "") == code)
    return str(state.problem)


def ready(driver: Driver) -> None:
    until(driver, lambda state: state.connected and state.problem is None)


def feed(driver: Driver, twist: Twist, for_s: float, turn: int = 1) -> None:
    """Send `twist` 50 times a second."""
    end_s = time.monotonic() + for_s
    while time.monotonic() < end_s:
        driver.apply(twist, turn)
        time.sleep(0.02)


def drive(driver: Driver, rover: Rover, turn: int = 1) -> None:
    """Send standstill, then motion, until the rover drives; repeat it on a busy machine."""
    begun_s = time.monotonic()
    anew_s = begun_s
    while not rover.drives:
        now_s = time.monotonic()
        assert now_s < begun_s + 10.0, (driver.state(), rover.events()[-9:])
        if now_s >= anew_s:
            driver.apply(STANDSTILL, turn)
            anew_s = now_s + 2.0
        feed(driver, Twist(0.3, 0.5), 0.02, turn)
