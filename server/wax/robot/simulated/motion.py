"""How the simulated robot moves (pure): speed ramps, a planar base, walls that stop it."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from wax.driver.checks import within
from wax.driver.interface import STANDSTILL, Pose

if TYPE_CHECKING:
    from wax.driver.interface import Limits, Twist
    from wax.robot.simulated.world import World

RADIUS_M = 0.17
ACCELERATION_MPS2 = 1.5
BRAKING_MPS2 = 4.0
ACCELERATION_RPS2 = 8.0
BRAKING_RPS2 = 16.0
GAP_M = 5e-5
"""The gap left between the robot and an obstacle it has run into."""


@dataclass(frozen=True, slots=True)
class Motion:
    """The robot's pose and speed; `impact_mps` is the speed lost in a bump in this step."""

    pose: Pose
    linear_mps: float = 0.0
    angular_rps: float = 0.0
    lateral_mps: float = 0.0
    impact_mps: float = 0.0


def step(motion: Motion, target: Twist, limits: Limits, world: World, dt_s: float) -> Motion:
    """Move on by `dt_s` towards the speed `target`.

    The robot's circle of `RADIUS_M` never enters an obstacle, and its speed never exceeds
    `limits`. It slides along an obstacle that it meets at an angle, with the part of its speed
    that points that way.
    """
    if target == STANDSTILL and motion == Motion(motion.pose):
        return motion
    wanted = within(target, limits)
    asked = complex(wanted.linear_mps, wanted.lateral_mps)
    speed = complex(motion.linear_mps, motion.lateral_mps)
    speed = _ramp(speed, asked, ACCELERATION_MPS2 * dt_s, BRAKING_MPS2 * dt_s)
    spin = complex(motion.angular_rps)
    spin = _ramp(spin, complex(wanted.angular_rps), ACCELERATION_RPS2 * dt_s, BRAKING_RPS2 * dt_s)
    angular = spin.real
    old = motion.pose
    way = speed * dt_s * cmath.rect(1.0, old.heading_rad + angular * dt_s / 2.0)
    x, y, free = _slide(world, old.x_m, old.y_m, way.real, way.imag)
    heading = math.remainder(old.heading_rad + angular * dt_s, math.tau)
    pose = Pose(x, y, heading)
    if free >= 1.0:
        return Motion(pose, speed.real, angular, speed.imag)
    kept = speed / abs(speed) * min(abs(speed), abs(asked) * free)
    return Motion(pose, kept.real, angular, kept.imag, impact_mps=abs(speed - kept))


def _ramp(speed: complex, target: complex, gain: float, brake: float) -> complex:
    """Step towards `target`, by at most `brake` if that slows down or reverses, else `gain`."""
    rest = target - speed
    slows = abs(target) < abs(speed) or (target * speed.conjugate()).real < 0.0
    most = brake if slows else gain
    return target if abs(rest) <= most else speed + rest / abs(rest) * most


def _slide(world: World, x: float, y: float, dx: float, dy: float) -> tuple[float, float, float]:
    """Move as far as obstacles allow; return the fraction of the speed that is left, 1 for all."""
    length = math.hypot(dx, dy)
    if length == 0.0:
        return x, y, 1.0
    new_x, new_y, free = x + dx, y + dy, 1.0
    for _ in range(4):
        distance, away_x, away_y = world.nearest_surface(new_x, new_y)
        if distance >= RADIUS_M:
            if math.hypot(new_x - x, new_y - y) <= length * (1.0 + 1e-9):
                return new_x, new_y, free
            break
        against = (dx * away_x + dy * away_y) / length
        free = min(free, math.sqrt(max(0.0, 1.0 - against**2)))
        push = RADIUS_M - distance + GAP_M
        new_x, new_y = new_x + push * away_x, new_y + push * away_y
    return x, y, 0.0
