"""Find the driver that the configuration names, and decide in which process it runs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import structlog

from wax.errors import ConfigError, PluginError
from wax.plugin import DRIVERS, find_offer, is_plugin_name
from wax.robot.build_driver import KEY, check_sideways, make_driver
from wax.robot.check_controls import check_controls
from wax.robot.hand.source import no_hand
from wax.robot.known import Known, look
from wax.robot.media.process import MediaProcess
from wax.robot.sensing_driver import SensingDriver

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.clock import Clock
    from wax.config.controls import ControlSettings
    from wax.config.local import LocalSettings
    from wax.config.log import LogSettings
    from wax.config.robot import RobotSettings
    from wax.driver.interface import Driver

__all__ = ["make_driver", "make_robot"]

_LOG = structlog.get_logger(__name__)

_ABOARD_TTL_S: Final = 1.0

NO_WATCHDOG: Final = (
    "if the driver's process hangs, or the link to the robot is cut, the robot keeps moving: its"
    " driver declares no watchdog of the robot's own (ttl_s)"
)
NOT_BUILT: Final = "the driver cannot be built; picture and sound are served without it"


def make_robot(
    settings: RobotSettings,
    clock: Clock,
    log: LogSettings | None = None,
    local: LocalSettings | None = None,
    *,
    claim: str = "",
    controls: Sequence[ControlSettings] = (),
) -> Driver:
    """Build the driver that the server uses, not yet opened; raises `ConfigError`.

    The driver runs in a driver process, which stops the robot when the server is silent or gone;
    the robot's camera, microphone and speaker run in another, the media process. Only the simulated
    robot runs inside the server process: its camera draws the state that its motion has there, and
    it can hurt nobody.

    A third-party driver is not built here but inspected in a process of its own. If building it
    fails, the server keeps running, and the page says so until the driver can be built.

    `local` is the hand control of a person aboard, who must not depend on the server. `claim` is
    the file by which a driver process takes over from an older one. `controls` are the robot's
    controls that people may use.
    """
    has_passenger = local is not None and local.is_on
    if settings.driver == "simulated":
        if local is not None and local.is_on:
            from wax.robot.simulated.chair import SimulatedChair  # noqa: PLC0415 - it draws

            robot: Driver = SimulatedChair(settings, local, clock, controls)
            check_sideways(settings, robot.limits)
        else:
            robot = make_driver(settings, clock)
        check_controls(robot.limits, settings.driver, controls)
        return robot
    try:
        known = _look(settings, clock, log)
        check_controls(known.limits, settings.driver, controls)
    except PluginError as error:
        if has_passenger:
            raise
        _LOG.error(NOT_BUILT, problem=str(error))
        known = Known.guessed(settings)
    if local is not None and local.is_on:
        _check_passenger(known, settings, local)
    elif known.limits.ttl_s is None:
        _LOG.warning(NO_WATCHDOG, driver=settings.driver)
    return SensingDriver(
        settings,
        clock,
        known=known,
        media=MediaProcess(settings, log),
        log=log,
        local=local,
        claim=claim,
        controls=controls,
    )


def _look(settings: RobotSettings, clock: Clock, log: LogSettings | None) -> Known:
    """Inspect the driver; a third-party one is never loaded into this process."""
    name = settings.driver
    offer = None if is_plugin_name(name) else find_offer(name, DRIVERS, KEY)
    if offer is not None and offer.is_ours:
        return Known.of(make_driver(settings, clock), settings)
    return look(settings, log)


def _check_passenger(known: Known, settings: RobotSettings, local: LocalSettings) -> None:
    """Raise `ConfigError` if a person aboard would depend on the server, or has no control."""
    if known.limits.ttl_s is not None and known.limits.ttl_s > _ABOARD_TTL_S:
        raise ConfigError(
            f"local.source: {settings.driver} stops by itself only after {known.limits.ttl_s:g} s"
            f" (ttl_s), with somebody in it {_ABOARD_TTL_S:g} s are allowed: give its watchdog less"
        )
    if known.limits.ttl_s is None:
        raise ConfigError(
            f"local.source: {settings.driver} declares no watchdog of its own (ttl_s), so nothing"
            " would stop it if its driver process hung, whoever sits in it; give it one, with the"
            ' serial driver by dialect = "frames"'
        )
    if local.source == "robot" and not known.has_hand:
        raise no_hand()
