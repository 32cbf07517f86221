"""The limits and timeouts for driving, from the configuration and the robot, in SI units."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

if TYPE_CHECKING:
    from wax.config.drive import DriveSettings
    from wax.config.robot import RobotSettings
    from wax.driver.interface import Limits


@dataclass(frozen=True, slots=True)
class Rules:
    """Constant while the server runs.

    `period_s` is the time between two set-points of the loop, `silence_s` how late one may be
    before the driver process stops the robot. `watchdog_s` is the longest timeout beyond the gate:
    the driver process's or, if known, the robot's own. The last two are the braking rates for
    motion that need not end at once.
    """

    limits: Limits
    max_age_s: float
    max_command_age_s: float
    slow_picture_age_s: float
    stop_picture_age_s: float
    max_stop_distance_m: float
    slow_fraction: float
    period_s: float
    silence_s: float
    watchdog_s: float
    acceleration_mps2: float
    acceleration_rps2: float
    soft_braking: bool
    braking_mps2: float
    braking_rps2: float

    @classmethod
    def of(cls, drive: DriveSettings, robot: RobotSettings, limits: Limits) -> Self:
        """Gather the rules from the configuration and the robot's driver."""
        return cls(
            limits=limits,
            max_age_s=drive.max_age_ms / 1000,
            max_command_age_s=drive.max_command_age_ms / 1000,
            slow_picture_age_s=drive.slow_picture_age_ms / 1000,
            stop_picture_age_s=drive.stop_picture_age_ms / 1000,
            max_stop_distance_m=drive.max_stop_distance_m,
            slow_fraction=drive.slow_fraction,
            period_s=1 / drive.loop_hz,
            silence_s=robot.silence_ms / 1000,
            watchdog_s=max(robot.silence_ms / 1000, limits.ttl_s or 0.0),
            acceleration_mps2=robot.max_linear_acceleration_mps2,
            acceleration_rps2=robot.max_angular_acceleration_rps2,
            soft_braking=robot.soft_braking,
            braking_mps2=robot.braking_mps2,
            # With this rate the wheels brake equally when turning on the spot and going straight.
            braking_rps2=robot.braking_mps2 / robot.lever_m,
        )
