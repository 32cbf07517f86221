"""Converts the speeds of two wheels to the motors' duty cycles (pure)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from wax.driver.interface import STANDSTILL
from wax.robot.wheels import WheelMixer

if TYPE_CHECKING:
    from wax.config.robot import RobotSettings
    from wax.driver.interface import Twist
    from wax.robot.gpio.settings import GpioSettings


@dataclass(frozen=True, slots=True)
class Shares:
    """The motors' duty cycles, -1 to 1 of the full voltage, as the motors are wired."""

    left: float = 0.0
    right: float = 0.0


OFF = Shares()


class MotorOpening:
    """Computes the duty cycles for a twist, by the robot's geometry, trims and inversions."""

    def __init__(self, robot: RobotSettings, gpio: GpioSettings) -> None:
        self._mixer = WheelMixer(robot)
        self._inverted = (robot.invert_left, robot.invert_right)
        on_the_spot_mps = robot.max_angular_rps * robot.wheel_base_m / 2.0
        self._full_mps = gpio.full_speed_mps or max(robot.max_linear_mps, on_the_spot_mps)
        self._dead = gpio.dead_share

    def shares(self, twist: Twist) -> Shares:
        """Return the duty cycles, never beyond -1…1."""
        wheels = self._mixer.mix(twist)
        return Shares(self._share(wheels.left_mps), self._share(wheels.right_mps))

    def directions(self, twist: Twist) -> tuple[int, int]:
        """Return each wheel's direction: 1 is forward, 0 standstill."""
        wheels = self._mixer.mix(twist)
        left, right = (
            (speed_mps > 0.0) - (speed_mps < 0.0)
            for speed_mps in (wheels.left_mps, wheels.right_mps)
        )
        return -left if self._inverted[0] else left, -right if self._inverted[1] else right

    def _share(self, speed_mps: float) -> float:
        if speed_mps == 0.0:
            return 0.0
        share = min(1.0, abs(speed_mps) / self._full_mps)
        opened = self._dead + (1.0 - self._dead) * share
        return opened if speed_mps > 0.0 else -opened


def unless_bumped(twist: Twist, *, front: bool, back: bool) -> Twist:
    """Return standstill for motion towards a pressed bumper, else the twist."""
    towards = (front and twist.linear_mps > 0.0) or (back and twist.linear_mps < 0.0)
    return STANDSTILL if towards else twist
