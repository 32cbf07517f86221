"""The sources of hand control readings: the robot itself, or a separate serial line."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Protocol, get_args

import structlog

from wax.driver.hand import HandReading, HasHand
from wax.driver.interface import Ask
from wax.errors import ConfigError
from wax.robot.hand.serial_hand import SerialHand

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config.local import LocalSettings

_LOG = structlog.get_logger(__name__)

LOOK_S: Final = 0.01
"""The poll interval for a control that cannot wake the loop."""

_CONTRACT: Final = "wax/driver/hand.py"


class HandSource(Protocol):
    """The readings of one control; all methods return at once."""

    @property
    def wakes(self) -> int | None:
        """The descriptor that becomes readable with new readings; None: poll every `LOOK_S`."""
        ...

    def open(self) -> None:
        """Start reading; wait for a control that is not there yet."""
        ...

    def take(self) -> tuple[HandReading, ...] | None:
        """Return the readings since the last call, oldest first; None if the control is gone."""
        ...

    def close(self) -> None:
        """Stop reading; takes at most a second, safe to call twice."""
        ...


class RobotsHand:
    """The built-in control of a robot."""

    wakes: int | None = None

    def __init__(self, robot: HasHand) -> None:
        self._robot = robot
        self._is_told = False

    def open(self) -> None:
        """Do nothing: opening the robot opens its control."""

    def take(self) -> tuple[HandReading, ...] | None:
        try:
            said = self._robot.hand()
            reading = None if said is None else _checked(said)
        except Exception:
            if not self._is_told:
                _LOG.exception("the robot's hand control failed; nobody drives")
            self._is_told = True
            return None
        self._is_told = False
        return None if reading is None else (reading,)

    def close(self) -> None:
        """Do nothing: closing the robot closes its control."""


def _checked(said: object) -> HandReading:
    """Convert a reading of a robot's own control to our types; raises if it is not a reading."""
    if not isinstance(said, HandReading):
        raise TypeError(f"hand() returned {said!r}, not a HandReading")
    if said.ask not in (None, *get_args(Ask)):
        raise ValueError(f"hand() has {said.ask!r} for ask")
    return HandReading(
        float(said.at_s),
        float(said.linear),
        float(said.angular),
        is_held=bool(said.is_held),
        stop=bool(said.stop),
        ask=said.ask,
        lateral=float(said.lateral),
    )


def make_hand(local: LocalSettings, robot: object, clock: Clock) -> HandSource:
    """Return the control that `[local]` names, not yet opened; raises `ConfigError`."""
    if local.source == "serial":
        return SerialHand(local, clock)
    if isinstance(robot, HasHand):
        return RobotsHand(robot)
    raise no_hand()


def no_hand() -> ConfigError:
    """Return the error for a robot without a control of its own."""
    return ConfigError(
        f"local.source: got 'robot', but this robot has no hand control; give its driver a method"
        f" hand ({_CONTRACT}), or write 'serial'"
    )
