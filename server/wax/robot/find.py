"""Find the driver that the configuration names."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

from wax.errors import ConfigError
from wax.plugin import is_plugin_name, load_class
from wax.robot.serial.driver import SerialRobot
from wax.robot.simulated.robot import SimulatedRobot

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config import RobotSettings
    from wax.robot.driver import Driver


def make_driver(settings: RobotSettings, clock: Clock) -> Driver:
    """Build the driver of `[robot] driver`, not yet opened; raises `ConfigError`."""
    name = settings.driver
    if name == "simulated":
        return SimulatedRobot(settings, clock)
    if name == "serial":
        return SerialRobot(settings, clock)
    if is_plugin_name(name):
        return cast("Driver", load_class(name, "robot.driver")(settings, clock))
    raise ConfigError(
        f"robot.driver: got {name!r}; possible are 'simulated', 'serial', "
        "or your own class as 'package.module:Class'"
    )
