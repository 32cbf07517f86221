"""Rules for the tests of the pure policies, with numbers that are easy to calculate with."""

from __future__ import annotations

import math
from typing import Final

from wax.control.picture_clock import PictureClock
from wax.control.rules import Rules
from wax.driver.interface import Limits

RULES: Final = Rules(
    limits=Limits(linear_mps=0.8, angular_rps=2.0, axes=("pan",)),
    max_age_s=0.15,
    max_command_age_s=0.5,
    slow_picture_age_s=0.4,
    stop_picture_age_s=0.8,
    max_stop_distance_m=2.0,
    slow_fraction=0.5,
    period_s=0.02,
    silence_s=0.0,
    watchdog_s=0.12,
    acceleration_mps2=1.0,
    acceleration_rps2=4.0,
    soft_braking=False,
    braking_mps2=2.0,
    braking_rps2=8.0,
)
"""A robot that stops in time from any speed, braked at once."""

VOUCHED: Final = PictureClock(since_s=-math.inf)
"""A clock that knows every picture's capture time exactly."""
