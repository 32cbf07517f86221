"""Find the driver that the configuration names, and decide in which process it runs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import structlog

from wax.driver.interface import HasCamera, HasExternalView, HasMicrophone, HasSpeaker, Limits
from wax.errors import ConfigError
from wax.plugin import DRIVERS, make_plugin
from wax.robot.hand.source import make_hand
from wax.robot.process.driver import ProcessDriver

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config.settings import LocalSettings, LogSettings, RobotSettings
    from wax.driver.interface import Driver

_LOG = structlog.get_logger(__name__)

NO_WATCHDOG: Final = (
    "if this server hangs, the robot keeps moving: its driver runs in the server process, because"
    " it has a camera, microphone or speaker, and declares no watchdog of its own (ttl_s)"
)
_KEY: Final = "robot.driver"
_CONTRACT: Final = "wax/driver/interface.py"
_METHODS: Final = ("open", "apply", "set_axis", "stop", "close", "state")


def make_robot(
    settings: RobotSettings,
    clock: Clock,
    log: LogSettings | None = None,
    local: LocalSettings | None = None,
    claim: str = "",
) -> Driver:
    """Build the driver that the server uses, not yet opened; raises `ConfigError`.

    It runs in a driver process, which stops the robot when the server is silent or gone. Only a
    robot with its own camera, microphone or speaker runs inside the server process, because it
    shares memory with them. Either way the driver is built here, to read its kind and limits.

    `local` is the hand control of a person aboard, who must not depend on the server: only the
    simulated robot, in which nobody sits, may have one in the server's process. `claim` is the file
    by which a driver process takes over from an older one.
    """
    driver = make_driver(settings, clock)
    if local is not None and local.is_on:
        _check_passenger(driver, settings, local, clock)
        if settings.driver == "simulated":
            from wax.robot.simulated.chair import SimulatedChair  # noqa: PLC0415 - it draws

            return SimulatedChair(settings, local, clock)
    elif isinstance(driver, HasCamera | HasExternalView | HasMicrophone | HasSpeaker):
        if driver.limits.ttl_s is None:
            _LOG.warning(NO_WATCHDOG, driver=settings.driver)
        return driver
    return ProcessDriver(
        settings,
        clock,
        kind=driver.kind,
        limits=driver.limits,
        log=log,
        local=local,
        claim=claim,
    )


def _check_passenger(
    driver: Driver, settings: RobotSettings, local: LocalSettings, clock: Clock
) -> None:
    """Raise `ConfigError` where a person aboard would depend on one process, or has no control."""
    if settings.driver == "simulated":
        return
    if isinstance(driver, HasCamera | HasExternalView | HasMicrophone | HasSpeaker):
        raise ConfigError(
            f"local.source: {settings.driver} has a camera, microphone or speaker, so it is driven"
            " from the server's process; with somebody aboard it must go on without it: give"
            " picture and sound a source of their own"
        )
    if driver.limits.ttl_s is None:
        raise ConfigError(
            f"local.source: {settings.driver} declares no watchdog of its own (ttl_s), so nothing"
            " would stop it if its driver process hung, whoever sits in it; give it one, with the"
            ' serial driver by dialect = "frames"'
        )
    make_hand(local, driver, clock)  # not opened


def make_driver(settings: RobotSettings, clock: Clock) -> Driver:
    """Build the driver of `[robot] driver` itself, not yet opened; raises `ConfigError`."""
    name = settings.driver
    driver: Driver = make_plugin(
        name, _KEY, settings, clock, needs=_METHODS, contract=_CONTRACT, group=DRIVERS
    )
    _check_properties(name, driver)
    return driver


def _check_properties(name: str, driver: Driver) -> None:
    """Check the properties that must be known before the robot is opened."""
    try:
        kind, limits = driver.kind, driver.limits
    except Exception as error:
        raise ConfigError(f"{_KEY}: {name} does not provide kind and limits: {error!r}") from error
    if not isinstance(kind, str) or not isinstance(limits, Limits):
        raise ConfigError(
            f"{_KEY}: {name} must have a text as kind and Limits as limits; see {_CONTRACT}."
        )
    if not all(0.0 <= most < math.inf for most in (limits.linear_mps, limits.angular_rps)):
        raise ConfigError(f"{_KEY}: {name} must have limits from 0 on; got {limits}.")
    if not isinstance(limits.axes, tuple) or not all(isinstance(axis, str) for axis in limits.axes):
        raise ConfigError(f"{_KEY}: {name} must name its axes in a tuple; got {limits.axes!r}.")
