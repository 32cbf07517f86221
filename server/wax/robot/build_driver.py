"""Build the driver that the configuration names.

It is separate from `find_driver` so that a restarting driver process need not wait for the media
libraries to load.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from pydantic import TypeAdapter, ValidationError

from wax.driver.interface import HasControls, Limits
from wax.errors import ConfigError, PluginError
from wax.plugin import DRIVERS, make_plugin

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config.robot import RobotSettings
    from wax.driver.interface import Driver

KEY: Final = "robot.driver"
_CONTRACT: Final = "wax/driver/interface.py"
_METHODS: Final = ("open", "apply", "set_axis", "stop", "close", "state")
_LIMITS: Final = TypeAdapter(Limits)


def make_driver(settings: RobotSettings, clock: Clock) -> Driver:
    """Build the driver of `[robot] driver` itself, not yet opened; raises `ConfigError`."""
    name = settings.driver
    driver: Driver = make_plugin(
        name, KEY, settings, clock, needs=_METHODS, contract=_CONTRACT, group=DRIVERS
    )
    _check_properties(name, driver)
    check_sideways(settings, driver.limits)
    return driver


def limits_of(driver: Driver, settings: RobotSettings) -> Limits:
    """Return the driver's limits, none of its speeds above the one configured in `[robot]`."""
    own = driver.limits
    return replace(
        own,
        linear_mps=min(own.linear_mps, settings.max_linear_mps),
        angular_rps=min(own.angular_rps, settings.max_angular_rps),
        lateral_mps=min(own.lateral_mps, settings.lateral_mps),
    )


def check_sideways(settings: RobotSettings, limits: Limits) -> None:
    """Raise `ConfigError` if the robot is to move sideways, but cannot."""
    if settings.lateral_mps > 0 and limits.lateral_mps == 0:
        raise ConfigError(
            f"robot.max_lateral_mps: {settings.driver} cannot move this robot sideways; set it to"
            " 0, or see robot.base."
        )


def _check_properties(name: str, driver: Driver) -> None:
    """Check the properties that must be known before the robot is opened."""
    try:
        kind, limits = driver.kind, driver.limits
    except Exception as error:
        raise PluginError(f"{KEY}: {name} does not provide kind and limits: {error!r}") from error
    if not isinstance(kind, str) or not isinstance(limits, Limits):
        raise PluginError(
            f"{KEY}: {name} must have a text as kind and Limits as limits; see {_CONTRACT}."
        )
    for what, names in (("axes", limits.axes), ("controls", limits.controls)):
        if not isinstance(names, tuple) or not all(isinstance(one, str) for one in names):
            raise PluginError(f"{KEY}: {name} must name its {what} in a tuple; got {names!r}.")
    if limits.controls and not isinstance(driver, HasControls):
        raise PluginError(f"{KEY}: {name} names controls, but has no method control.")
    try:
        _LIMITS.validate_json(_LIMITS.dump_json(limits, warnings=False), strict=True)
        are_finite = all(
            0.0 <= most < math.inf
            for most in (limits.linear_mps, limits.angular_rps, limits.lateral_mps)
        )
    except (ValidationError, TypeError, ValueError):
        are_finite = False
    if not are_finite:
        raise PluginError(f"{KEY}: {name} must have limits from 0 on; got {limits}.")
