"""Find the driver that the configuration names."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.errors import ConfigError
from wax.plugin import is_plugin_name, make_plugin
from wax.robot.driver import Limits
from wax.robot.serial.driver import SerialRobot
from wax.robot.simulated.robot import SimulatedRobot

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config import RobotSettings
    from wax.robot.driver import Driver

_KEY: Final = "robot.driver"
_CONTRACT: Final = "wax/robot/driver.py"
_METHODS: Final = ("open", "apply", "set_axis", "stop", "close", "state")


def make_driver(settings: RobotSettings, clock: Clock) -> Driver:
    """Build the driver of `[robot] driver`, not yet opened; raises `ConfigError`."""
    name = settings.driver
    if name == "simulated":
        return SimulatedRobot(settings, clock)
    if name == "serial":
        return SerialRobot(settings, clock)
    if is_plugin_name(name):
        driver: Driver = make_plugin(
            name, _KEY, settings, clock, needs=_METHODS, contract=_CONTRACT
        )
        _check_properties(name, driver)
        return driver
    raise ConfigError(
        f"{_KEY}: got {name!r}; possible are 'simulated', 'serial', "
        "or your own class as 'package.module:Class'"
    )


def _check_properties(name: str, driver: Driver) -> None:
    """See to it that what must be known before the robot is opened is known."""
    try:
        kind, limits = driver.kind, driver.limits
    except Exception as error:
        raise ConfigError(f"{_KEY}: {name} does not tell kind and limits: {error!r}") from error
    if not isinstance(kind, str) or not isinstance(limits, Limits):
        raise ConfigError(
            f"{_KEY}: {name} must have a text as kind and Limits as limits; see {_CONTRACT}."
        )
