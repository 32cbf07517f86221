"""What the server knows of a driver before it is opened, and how it finds that out.

A third-party driver may do anything while it is imported and built: hang, print, end the process.
So it is built once in a process that only reports what it found (`wax.robot.look`).
"""

from __future__ import annotations

import subprocess
from typing import TYPE_CHECKING, Final, Self, get_args

from pydantic import BaseModel, ConfigDict, ValidationError

from wax.config.log import LogSettings
from wax.driver.hand import HasHand
from wax.driver.interface import KnowsItsView, Limits, OwnView
from wax.errors import ConfigError, PluginError
from wax.machine import python_module
from wax.robot.build_driver import KEY, limits_of
from wax.robot.media.messages import Sense
from wax.robot.process.pipe_messages import Begin, encode

if TYPE_CHECKING:
    from wax.config.robot import RobotSettings
    from wax.driver.interface import Driver

BUILD_S: Final = 20.0
"""A plug-in's libraries may take long to load on a small machine."""
_SENSES: Final = get_args(Sense)


class Known(BaseModel):
    """The driver's kind and limits, its senses, and whether it has a hand control.

    `is_guess` is set if the driver could not be built: then nothing is known about it, and all
    senses are tried.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    kind: str
    limits: Limits
    senses: tuple[Sense, ...] = ()
    own_view: OwnView | None = None
    has_hand: bool = False
    is_guess: bool = False

    @classmethod
    def of(cls, driver: Driver, settings: RobotSettings) -> Self:
        """Return what is known of a driver that was built with these settings."""
        return cls(
            kind=driver.kind,
            limits=limits_of(driver, settings),
            senses=tuple(one for one in _SENSES if callable(getattr(driver, one, None))),
            own_view=driver.own_view if isinstance(driver, KnowsItsView) else None,
            has_hand=isinstance(driver, HasHand),
        )

    @classmethod
    def guessed(cls, settings: RobotSettings) -> Self:
        """Return what the configuration says about a driver that cannot be built."""
        return cls(
            kind=settings.driver,
            limits=Limits(
                settings.max_linear_mps,
                settings.max_angular_rps,
                lateral_mps=settings.lateral_mps,
            ),
            senses=_SENSES,
            is_guess=True,
        )


class LookResult(BaseModel):
    """The looking process's answer: exactly one of these is set."""

    known: Known | None = None
    refused: str | None = None
    failed: str | None = None


def look(settings: RobotSettings, log: LogSettings | None = None) -> Known:
    """Build the driver in a process that then ends; this takes `BUILD_S` at most.

    Raises `ConfigError`, and `PluginError` if the driver fails.
    """
    begin = encode(Begin(robot=settings, log=log or LogSettings()))
    name = settings.driver
    try:
        done = python_module.ask("wax.robot.look", begin, BUILD_S)
    except subprocess.TimeoutExpired as error:
        raise PluginError(
            f"{KEY}: {name} hangs: building it takes longer than {BUILD_S:g} s"
        ) from error
    except OSError as error:
        raise PluginError(f"{KEY}: {name} cannot be looked at: {error}") from error
    try:
        seen = LookResult.model_validate_json(done.stdout)
    except ValidationError:
        how = f"signal {-done.returncode}" if done.returncode < 0 else f"status {done.returncode}"
        raise PluginError(f"{KEY}: {name} ends the process that builds it ({how})") from None
    if seen.known is not None:
        return seen.known
    if seen.refused is not None:
        raise ConfigError(seen.refused)
    raise PluginError(seen.failed or f"{KEY}: {name} cannot be built")
