"""Converts a set-point to the fields of MAVLink's two motion messages (pure).

MAVLink's body frame is forward, right and down: turning left is negative there. Nothing goes
sideways: ArduPilot Rover reads only y and z of MANUAL_CONTROL, whatever the frame, and drives the
length of a velocity ahead, even that of a velocity to the side (its `GCS_MAVLink_Rover.cpp`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from wax.driver.checks import within

if TYPE_CHECKING:
    from wax.driver.interface import Limits, Twist

FULL: Final = 1000
"""A stick's full deflection in MANUAL_CONTROL."""

BODY_FRAME: Final = 8
"""MAV_FRAME_BODY_NED."""

VELOCITY_AND_YAW_RATE: Final = 0b0000_0101_1100_0111
"""POSITION_TARGET_TYPEMASK: position, acceleration and yaw are to be ignored.

ArduPilot refuses a message that does not ignore the acceleration, or that ignores one of the three
velocities.
"""


@dataclass(frozen=True, slots=True)
class Sticks:
    """MANUAL_CONTROL as ArduPilot Rover reads it: y steers, z is the throttle, both ways."""

    y: int
    z: int


@dataclass(frozen=True, slots=True)
class Velocity:
    """SET_POSITION_TARGET_LOCAL_NED with a velocity and a yaw rate."""

    vx_mps: float
    yaw_rate_rps: float


def sticks(twist: Twist, limits: Limits) -> Sticks:
    """Return the stick deflections; the limits are full deflection."""
    allowed = within(twist, limits)
    return Sticks(
        y=-round(allowed.angular_rps / limits.angular_rps * FULL),
        z=round(allowed.linear_mps / limits.linear_mps * FULL),
    )


def velocity(twist: Twist, limits: Limits) -> Velocity:
    """Return the velocity, within the limits."""
    allowed = within(twist, limits)
    return Velocity(vx_mps=allowed.linear_mps, yaw_rate_rps=0.0 - allowed.angular_rps)
