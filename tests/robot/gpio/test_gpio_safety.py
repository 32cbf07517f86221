"""A robot on gpiozero's mock pins keeps the promises of `wax.testing`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from tests.robot.gpio.conftest import LEFT, MECANUM, RIGHT, Board, settings

from wax.driver.interface import Twist
from wax.robot.find_driver import make_driver
from wax.robot.wheels import WheelGeometry
from wax.testing import DriverSafety

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.clock import Clock
    from wax.driver.interface import Driver

FULL_MPS = 0.6


class TestGpio(DriverSafety):
    """Observed by the motors' duty cycles."""

    may_lose = False

    @pytest.fixture(autouse=True)
    def _robot(self, pins: Board) -> None:
        self.pins = pins

    def make_driver(self, clock: Clock) -> Driver:
        return make_driver(settings(servos={"pan": 18}, front_bumpers=[20]), clock)

    def commanded(self) -> Sequence[Twist]:
        left, right = self.pins.motor(LEFT), self.pins.motor(RIGHT)
        return [Twist((left + right) / 2 * FULL_MPS, (right - left) * FULL_MPS / 0.3)]


@pytest.mark.full
class TestGpioOnFourMotors(TestGpio):
    """A mecanum base, which moves sideways, too."""

    robot = settings({"base": "mecanum"}, **MECANUM, servos={"pan": 19}, full_speed_mps=1.0)

    def make_driver(self, clock: Clock) -> Driver:
        return make_driver(self.robot, clock)

    def commanded(self) -> Sequence[Twist]:
        shares = [self.pins.motor(motor) for motor in MECANUM.values()]
        return [WheelGeometry(self.robot).motion(shares)]
