"""How the simulated robot moves (pure): speed ramps, differential drive, walls that stop it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from wax.driver.checks import within
from wax.driver.interface import Pose

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
    impact_mps: float = 0.0

    def wheels_mps(self, wheel_base_m: float) -> tuple[float, float]:
        """Give the speeds of the left and the right wheel."""
        half = self.angular_rps * wheel_base_m / 2.0
        return self.linear_mps - half, self.linear_mps + half


def step(motion: Motion, target: Twist, limits: Limits, world: World, dt_s: float) -> Motion:
    """Move on by `dt_s` towards the speed `target`.

    The robot's circle of `RADIUS_M` never enters an obstacle, and its speed never exceeds
    `limits`. It slides along an obstacle that it meets at an angle, with the part of its speed
    that points that way.
    """
    wanted = within(target, limits)
    linear = _ramp(motion.linear_mps, wanted.linear_mps, ACCELERATION_MPS2, BRAKING_MPS2, dt_s)
    angular = _ramp(motion.angular_rps, wanted.angular_rps, ACCELERATION_RPS2, BRAKING_RPS2, dt_s)
    old = motion.pose
    middle = old.heading_rad + angular * dt_s / 2.0
    ahead_x, ahead_y = math.cos(middle), math.sin(middle)
    way = linear * dt_s
    x, y, free = _slide(world, old.x_m, old.y_m, way * ahead_x, way * ahead_y)
    heading = math.remainder(old.heading_rad + angular * dt_s, math.tau)
    pose = Pose(x, y, heading)
    if free >= 1.0:
        return Motion(pose, linear, angular)
    kept = math.copysign(min(abs(linear), abs(wanted.linear_mps) * free), linear)
    return Motion(pose, kept, angular, impact_mps=abs(linear - kept))


def _ramp(speed: float, target: float, gain: float, brake: float, dt_s: float) -> float:
    braking = abs(target) < abs(speed) or target * speed < 0.0
    most = (brake if braking else gain) * dt_s
    return speed + min(most, max(-most, target - speed))


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
