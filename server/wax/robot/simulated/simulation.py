"""The simulated robot without its threads: commands and time in, sensor values out (pure)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from wax.driver.checks import TurnFence, unit, within
from wax.driver.interface import STANDSTILL, Limits
from wax.robot.simulated.motion import Motion, step

if TYPE_CHECKING:
    from wax.config.settings import RobotSettings
    from wax.driver.interface import Pose, Twist
    from wax.robot.simulated.world import World

STEP_S = 0.01
TIME_TO_LIVE_S = 0.3
"""Without a new set-point for this long the robot stops, as real firmware would."""

PAN_LIMIT_RAD: Final = math.radians(60.0)
PAN_SPEED_RPS = 2.0
THUD_MPS = 0.05
"""A slower touch makes no sound and does not count as a bump."""

MAX_CATCH_UP_S = 0.5
"""After this long the robot stands anyway: watchdog plus braking."""


@dataclass(frozen=True, slots=True)
class Senses:
    """The input for camera and microphone at `at_s`; `pan_rad` is the head's angle to the left.

    `bumps` counts collisions; `bump_mps` is the speed of the newest one.
    """

    at_s: float
    pose: Pose
    pan_rad: float = 0.0
    left_mps: float = 0.0
    right_mps: float = 0.0
    bumps: int = 0
    bump_mps: float = 0.0


class Simulation:
    """A robot in a `world`. The same calls at the same times always give the same ride."""

    def __init__(self, settings: RobotSettings, world: World) -> None:
        self.limits = Limits(
            settings.max_linear_mps,
            settings.max_angular_rps,
            axes=("pan",),
            ttl_s=TIME_TO_LIVE_S,
        )
        self._world = world
        self._wheel_base_m = settings.wheel_base_m
        self._fence = TurnFence()
        self._target = STANDSTILL
        self._expires_s = 0.0
        self._pan_target_rad = 0.0
        self._motion = Motion(pose=world.start)
        self._senses = Senses(at_s=0.0, pose=world.start)

    @property
    def senses(self) -> Senses:
        """The newest sensor values."""
        return self._senses

    def start(self, now_s: float) -> None:
        """Start the simulation at `now_s`, standing still."""
        self._target = STANDSTILL
        self._motion = replace(self._motion, linear_mps=0.0, angular_rps=0.0)
        self._senses = replace(self._senses, at_s=now_s, left_mps=0.0, right_mps=0.0)

    def apply(self, twist: Twist, turn: int, now_s: float) -> None:
        """Take a set-point unless its turn is over; it is valid for `TIME_TO_LIVE_S`."""
        if self._fence.admits(turn):
            self._target = within(twist, self.limits)
            self._expires_s = now_s + TIME_TO_LIVE_S

    def set_axis(self, name: str, position: float, turn: int) -> None:
        """Turn the head towards `position`, 1 being all the way to the left."""
        if name in self.limits.axes and self._fence.admits(turn):
            self._pan_target_rad = unit(position) * PAN_LIMIT_RAD

    def stop(self, turn: int) -> None:
        """Brake, whatever the turn."""
        self._fence.admits(turn)
        self._target = STANDSTILL

    def advance(self, now_s: float) -> Senses:
        """Simulate in whole steps up to `now_s`; an earlier time has no effect."""
        start_s = self._senses.at_s
        if now_s - start_s > MAX_CATCH_UP_S:
            start_s = now_s - MAX_CATCH_UP_S
        steps = int((now_s - start_s) / STEP_S + 1e-6)
        for number in range(1, steps + 1):
            self._step(start_s + number * STEP_S)
        return self._senses

    def _step(self, at_s: float) -> None:
        target = self._target if at_s < self._expires_s else STANDSTILL
        moved = step(self._motion, target, self.limits, self._world, STEP_S)
        self._motion = moved
        left, right = moved.wheels_mps(self._wheel_base_m)
        bumped = moved.impact_mps > THUD_MPS
        before = self._senses
        most = PAN_SPEED_RPS * STEP_S
        pan = before.pan_rad + min(most, max(-most, self._pan_target_rad - before.pan_rad))
        self._senses = Senses(
            at_s=at_s,
            pose=moved.pose,
            pan_rad=pan,
            left_mps=left,
            right_mps=right,
            bumps=before.bumps + bumped,
            bump_mps=moved.impact_mps if bumped else before.bump_mps,
        )
