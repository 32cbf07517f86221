"""Find the driver that the configuration names, and the process in which it shall live."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import structlog

from wax.driver.interface import HasCamera, HasMicrophone, Limits
from wax.errors import ConfigError
from wax.plugin import is_plugin_name, make_plugin
from wax.robot.process.driver import ProcessDriver
from wax.robot.serial.driver import SerialRobot

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config.settings import LogSettings, RobotSettings
    from wax.driver.interface import Driver

_LOG = structlog.get_logger(__name__)

NO_WATCHDOG: Final = (
    "should this server hang the robot goes on: its driver lives in the server's process, because"
    " it has a camera or a microphone, and names no ttl_s of a watchdog of its own"
)
_KEY: Final = "robot.driver"
_CONTRACT: Final = "wax/driver/interface.py"
_METHODS: Final = ("open", "apply", "set_axis", "stop", "close", "state")


def make_robot(settings: RobotSettings, clock: Clock, log: LogSettings | None = None) -> Driver:
    """Build what the server drives, not yet opened; raises `ConfigError`.

    That is the driver in a process of its own, which stops the robot when the server is silent or
    gone. Only a robot with a camera or a microphone of its own shares the server's process, as it
    shares its memory with them. The driver is built here in both cases, if only to be asked.
    """
    driver = make_driver(settings, clock)
    if isinstance(driver, HasCamera | HasMicrophone):
        if driver.limits.ttl_s is None:
            _LOG.warning(NO_WATCHDOG, driver=settings.driver)
        return driver
    return ProcessDriver(settings, clock, kind=driver.kind, limits=driver.limits, log=log)


def make_driver(settings: RobotSettings, clock: Clock) -> Driver:
    """Build the driver of `[robot] driver` itself, not yet opened; raises `ConfigError`."""
    name = settings.driver
    if name == "simulated":
        # Only here: it draws pictures, and no other robot's process shall wait for the libraries.
        from wax.robot.simulated.robot import SimulatedRobot  # noqa: PLC0415

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
    if not all(0.0 <= most < math.inf for most in (limits.linear_mps, limits.angular_rps)):
        raise ConfigError(f"{_KEY}: {name} must have limits from 0 on; got {limits}.")
    if not isinstance(limits.axes, tuple) or not all(isinstance(axis, str) for axis in limits.axes):
        raise ConfigError(f"{_KEY}: {name} must name its axes in a tuple; got {limits.axes!r}.")
