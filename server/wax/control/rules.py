"""What the configuration and the robot say of driving, in the units of `control`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

if TYPE_CHECKING:
    from wax.config.settings import DriveSettings, RobotSettings
    from wax.driver.interface import Limits


@dataclass(frozen=True, slots=True)
class Rules:
    """Constant while the server runs.

    `beat_s` is the time between two set-points of the loop, `silence_s` how late one may be before
    the driver's process stops the robot. `watchdog_s` is how long the slowest of the watchdogs
    beyond the gate waits: that process, and the robot itself if that is known. The last two are
    how fast motion may end where it need not end at once.
    """

    limits: Limits
    max_age_s: float
    max_command_age_s: float
    slow_picture_age_s: float
    stop_picture_age_s: float
    max_stop_distance_m: float
    slow_fraction: float
    beat_s: float
    silence_s: float
    watchdog_s: float
    acceleration_mps2: float
    acceleration_rps2: float
    soft_braking: bool
    braking_mps2: float
    braking_rps2: float

    @classmethod
    def of(cls, drive: DriveSettings, robot: RobotSettings, limits: Limits) -> Self:
        """Gather what the parts of the configuration and the robot's driver say."""
        return cls(
            limits=limits,
            max_age_s=drive.max_age_ms / 1000,
            max_command_age_s=drive.max_command_age_ms / 1000,
            slow_picture_age_s=drive.slow_picture_age_ms / 1000,
            stop_picture_age_s=drive.stop_picture_age_ms / 1000,
            max_stop_distance_m=drive.max_stop_distance_m,
            slow_fraction=drive.slow_fraction,
            beat_s=1 / drive.loop_hz,
            silence_s=robot.silence_ms / 1000,
            watchdog_s=max(robot.silence_ms / 1000, limits.ttl_s or 0.0),
            acceleration_mps2=robot.max_linear_acceleration_mps2,
            acceleration_rps2=robot.max_angular_acceleration_rps2,
            soft_braking=robot.soft_braking,
            braking_mps2=robot.braking_mps2,
            # At this the rims of the wheels of a robot that turns on the spot brake as they do
            # when it runs straight ahead.
            braking_rps2=robot.braking_mps2 / (robot.wheel_base_m / 2),
        )
