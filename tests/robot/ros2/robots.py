"""Drives a robot on ROS 2 as the control loop does."""

from __future__ import annotations

import random
import time
from typing import TYPE_CHECKING, Any, Protocol

from wax.config.robot import RobotSettings
from wax.driver.interface import STANDSTILL, Twist

if TYPE_CHECKING:
    from collections.abc import Callable

    from tests.robot.ros2.base import Told

    from wax.driver.interface import Driver, RobotState


class Hears(Protocol):
    """The robot's end of any transport."""

    def told(self) -> list[Told]:
        """Return the commands so far."""
        ...


def ros2_settings(domain: int, *, base: str = "differential", **own: Any) -> RobotSettings:
    """Return the settings of a robot on this machine, with wheels as `base` says."""
    ros2 = {"domain": domain, "interface": "127.0.0.1", "zeros_s": 1.5, "reopen_s": 0.05}
    return RobotSettings.model_validate(
        {"driver": "ros2", "base": base, "ros2": ros2 | {"odometry": "/odom"} | own}
    )


def until(driver: Driver, so: Callable[[RobotState], bool], within_s: float = 20.0) -> None:
    end_s = time.monotonic() + within_s
    while not so(driver.state()):
        assert time.monotonic() < end_s, driver.state()
        time.sleep(0.005)


def opened(driver: Driver) -> Driver:
    driver.open()
    until(driver, lambda state: state.connected)
    driver.apply(STANDSTILL, 1)
    return driver


def feed(driver: Driver, twist: Twist, *, for_s: float, every_s: float = 0.02) -> None:
    end_s = time.monotonic() + for_s
    while time.monotonic() < end_s:
        driver.apply(twist, 1)
        time.sleep(every_s)


def driven(base: Hears, driver: Driver, twist: Twist) -> None:
    """Drive from standstill until the base has received it; retry on a busy machine."""
    end_s = time.monotonic() + 5.0
    while not any(told.twist == twist for told in base.told()):
        assert time.monotonic() < end_s, (base.told()[-5:], driver.state())
        driver.apply(STANDSTILL, 1)
        feed(driver, twist, for_s=0.04)


def standing(base: Hears) -> None:
    """Wait until the base's newest command is standstill: no other is under way."""
    end_s = time.monotonic() + 5.0
    while not (told := base.told()) or not told[-1].twist.is_zero:
        assert time.monotonic() < end_s, told[-5:]
        time.sleep(0.005)


def told(driver: Driver, tell: Callable[[], None], so: Callable[[RobotState], bool]) -> RobotState:
    """Call `tell` repeatedly, as robots publish, until `so` holds for the driver's state."""
    end_s = time.monotonic() + 20.0
    while not so(state := driver.state()):
        assert time.monotonic() < end_s, state
        tell()
        time.sleep(0.05)
    return state


def key_to_wire_s(base: Hears, driver: Driver, count: int) -> list[float]:
    """Send `count` new set-points at random phases, and return how long each took to arrive."""
    driven(base, driver, Twist(0.1, 0.0))
    said: dict[Twist, float] = {}
    for number in range(count):
        twist = Twist(0.1 + 0.001 * (number % 400), 0.25 * (1 + number // 400))
        said[twist] = time.monotonic()
        driver.apply(twist, 1)
        time.sleep(random.uniform(0.02, 0.05))
    time.sleep(0.3)
    arrived: dict[Twist, float] = {}
    for told in base.told():
        arrived.setdefault(told.twist, told.at_s)
    return sorted(arrived[twist] - at_s for twist, at_s in said.items())
