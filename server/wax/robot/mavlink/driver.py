"""The driver for a ground rover or boat with ArduPilot, by MAVLink."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.driver.interface import Limits
from wax.robot.line.robot import LineRobot
from wax.robot.mavlink.settings import MavlinkSettings
from wax.robot.mavlink.signing_key import read_key

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config.robot import RobotSettings


class MavlinkRobot(LineRobot):
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
        limits = Limits(
            settings.max_linear_mps,
            settings.max_angular_rps,
            ttl_s=own.failsafe_s or None,
        )
        key = read_key(own.signing_key) if own.signing_key else None
        core = Conversation(own, limits, clock, key)
        line = MavlinkLink(own, clock, core)
        super().__init__("mavlink", limits, clock, core, line, reopen_s=own.reopen_s)
