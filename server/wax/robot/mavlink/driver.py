"""The driver for a ground rover or boat with ArduPilot, by MAVLink."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.driver.interface import Limits
from wax.robot.mavlink.settings import MavlinkSettings
from wax.robot.mavlink.signing_key import read_key

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config.robot import RobotSettings
    from wax.driver.interface import RobotState, Twist


class MavlinkRobot:
    """A `Driver` for one system on a MAVLink line.

    The driver never arms it and never changes its mode: a person does that, by a transmitter or a
    ground station. The limit `ttl_s` is the configured `failsafe_s`; nobody drives a rover whose
    parameters do not meet it.
    """

    Settings = MavlinkSettings

    def __init__(self, settings: RobotSettings, clock: Clock) -> None:
        # pymavlink is an optional dependency, and slow to load.
        from wax.robot.mavlink.conversation import Conversation  # noqa: PLC0415
        from wax.robot.mavlink.link import MavlinkLink  # noqa: PLC0415

        own = settings.own(MavlinkSettings)
        self._limits = Limits(
            settings.max_linear_mps,
            settings.max_angular_rps,
            ttl_s=own.failsafe_s or None,
        )
        key = read_key(own.signing_key) if own.signing_key else None
        self._clock = clock
        self._conversation = Conversation(own, self._limits, clock, key)
        self._link = MavlinkLink(own, clock, self._conversation)

    @property
    def kind(self) -> str:
        return "mavlink"

    @property
    def limits(self) -> Limits:
        return self._limits

    def open(self) -> None:
        """Start opening the line; `state` reports whether the rover answers."""
        self._link.open()

    def apply(self, twist: Twist, turn: int) -> None:
        self._conversation.apply(twist, turn, self._clock.now_s())
        self._link.wake()

    def set_axis(self, name: str, position: float, turn: int) -> None:
        """Do nothing: it has no axes."""

    def stop(self, turn: int) -> None:
        self._conversation.stop(turn, self._clock.now_s())
        self._link.wake()

    def close(self) -> None:
        self._link.close()

    def state(self) -> RobotState:
        return self._conversation.state()
