"""A robot on gpiozero's mock pins keeps the promises of `wax.testing`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from tests.robot.gpio.conftest import LEFT, RIGHT, Board, settings

from wax.driver.interface import Twist
from wax.robot.find_driver import make_driver
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
