"""Rules for the tests of the pure policies, with numbers that are easy to calculate with."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

from wax.config.drive import DriveSettings
from wax.config.robot import RobotSettings
from wax.control.picture_clock import PictureClock
from wax.control.rules import Rules
from wax.driver.interface import Limits

RULES: Final = replace(
    Rules.of(
        DriveSettings(max_stop_distance_m=2.0, slow_fraction=0.5),
        RobotSettings(
            max_linear_acceleration_mps2=1.0, max_angular_acceleration_rps2=4.0, wheel_base_m=0.5
        ),
        Limits(linear_mps=0.8, angular_rps=2.0, axes=("pan",), lateral_mps=0.4),
    ),
    silence_s=0.0,
)
"""A robot that stops in time from any speed, braked at once; half as fast sideways as ahead."""

VOUCHED: Final = PictureClock(since_s=-math.inf)
"""A clock that knows every picture's capture time exactly."""
