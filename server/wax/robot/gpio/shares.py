"""Converts the speeds of the wheels to the motors' duty cycles (pure)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.driver.interface import STANDSTILL
from wax.robot.wheels import WheelMixer

if TYPE_CHECKING:
    from wax.config.robot import RobotSettings
    from wax.driver.interface import Twist
    from wax.robot.gpio.settings import GpioSettings


class MotorOpening:
    """Computes the duty cycles for a twist, by the robot's geometry, trims and inversions."""

    def __init__(self, robot: RobotSettings, gpio: GpioSettings) -> None:
        self._mixer = WheelMixer(robot)
        self._full_mps = gpio.full_speed_mps or self._mixer.fastest_mps
        self._dead = gpio.dead_share

    def shares(self, twist: Twist) -> list[float]:
        """Return each motor's share of the full voltage, -1 to 1, as the motors are wired."""
        return [self._share(speed_mps) for speed_mps in self._mixer.mix(twist).values()]

    def directions(self, twist: Twist) -> list[int]:
        """Return each wheel's direction: 1 is forward, 0 standstill."""
        signs = self._mixer.geometry.signs
        rolls = [speed_mps * signs[wheel] for wheel, speed_mps in self._mixer.mix(twist).items()]
        return [(one > 0.0) - (one < 0.0) for one in rolls]

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
