"""The driver for a robot whose motors are wired to this computer's GPIO pins."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.config.bases import WHEELS_OF
from wax.driver.interface import Limits
from wax.errors import ConfigError
from wax.robot.gpio.pin_line import PinLine
from wax.robot.gpio.settings import GpioSettings
from wax.robot.line.core import LineCore
from wax.robot.line.robot import LineRobot

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config.robot import RobotSettings

SETPOINT_TTL_S: Final = 0.2
"""The driver's process repeats the set-point 50 times a second."""


class GpioRobot(LineRobot):
    """A `Driver` for motors on H-bridges, servos, encoders and bumpers.

    Pins have no watchdog of their own (`ttl_s` is None): this driver switches the motors off when
    set-points cease, the driver process when the server is silent, and `guard` when that process
    has died.
    """

    Settings = GpioSettings

    def __init__(self, settings: RobotSettings, clock: Clock) -> None:
        import gpiozero  # noqa: F401, PLC0415 - said at the start where it is missing

        own = settings.own(GpioSettings)
        if own.base != settings.base:
            raise ConfigError(
                f'robot.base: is "{settings.base}", but [robot.gpio] has the pins of'
                f' {", ".join(own.motors[1])}; set it to "{own.base}", or give those of'
                f" {', '.join(WHEELS_OF[settings.base])}"
            )
        limits = Limits(
            settings.max_linear_mps,
            settings.max_angular_rps,
            axes=tuple(own.servos),
            lateral_mps=0.0 if own.base == "differential" else settings.lateral_mps,
        )
        core = LineCore(limits, SETPOINT_TTL_S)
        line = PinLine(settings, own, core)
        super().__init__("gpio", limits, clock, core, line, reopen_s=own.reopen_s)
