"""The simulated robot without its threads: commands and time in, sensor values out (pure)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

from wax.driver.checks import TurnFence, unit, within
from wax.driver.interface import STANDSTILL, Limits, Twist
from wax.robot.simulated.lamp import FULL, LIGHTS, Lamp
from wax.robot.simulated.motion import Motion, step
from wax.robot.wheels import WheelGeometry

if TYPE_CHECKING:
    from wax.config.robot import RobotSettings
    from wax.driver.interface import ControlValue, Pose
    from wax.robot.simulated.world import World

STEP_S = 0.01
TIME_TO_LIVE_S = 0.3
"""Without a new set-point for this long the robot stops, as real firmware would."""

PAN_LIMIT_RAD: Final = math.radians(60.0)
PAN_SPEED_RPS = 2.0
THUD_MPS = 0.05
"""A slower impact makes no sound and does not count as a bump."""

CONTROLS: Final = ("lamp", "horn", "brightness", "light", "look_around")
LOOK_AROUND_RPS = 0.5

ROOM_C = 22.0
_WARMING_C_PER_M = 0.9
"""How much each metre that a wheel runs warms its motor."""
_COOLING_S = 90.0
"""The time constant with which a motor cools down."""

MAX_CATCH_UP_S = 0.5
"""After this long the robot stands anyway: watchdog plus braking."""


@dataclass(frozen=True, slots=True)
class Senses:
    """The input for camera and microphone at `at_s`; `pan_rad` is the head's angle to the left.

    `twist` is its speed, `wheels_mps` that of each wheel.
    `bumps` counts collisions; `bump_mps` is the speed of the newest one. `motor_c` is the warmest
    motor's temperature.
    """

    at_s: float
    pose: Pose
    pan_rad: float = 0.0
    twist: Twist = STANDSTILL
    wheels_mps: tuple[float, ...] = ()
    bumps: int = 0
    bump_mps: float = 0.0
    lamp: Lamp = field(default_factory=Lamp)
    is_honking: bool = False
    motor_c: float = ROOM_C


class Simulation:
    """A robot in a `world`. It is deterministic: the same calls at the same times move it alike."""

    def __init__(self, settings: RobotSettings, world: World) -> None:
        self._wheels = WheelGeometry(settings)
        self.limits = Limits(
            settings.max_linear_mps,
            settings.max_angular_rps,
            axes=("pan",),
            ttl_s=TIME_TO_LIVE_S,
            controls=CONTROLS,
            lateral_mps=settings.lateral_mps if self._wheels.moves_sideways else 0.0,
        )
        self._world = world
        self._fence = TurnFence()
        self._target = STANDSTILL
        self._expires_s = 0.0
        self._pan_target_rad = 0.0
        self._is_looking_around = False
        self._motion = Motion(pose=world.start)
        self._senses = Senses(at_s=0.0, pose=world.start)

    @property
    def senses(self) -> Senses:
        """The newest sensor values."""
        return self._senses

    def start(self, now_s: float) -> None:
        """Start the simulation at `now_s`, standing still."""
        self._let_go()
        self._motion = Motion(self._motion.pose)
        still = tuple(self._wheels.speeds_mps(STANDSTILL).values())
        self._senses = replace(self._senses, at_s=now_s, twist=STANDSTILL, wheels_mps=still)

    def apply(self, twist: Twist, turn: int, now_s: float) -> None:
        """Follow a set-point for `TIME_TO_LIVE_S`, unless its turn is over."""
        if self._fence.admits(turn):
            self._target = within(twist, self.limits)
            self._expires_s = now_s + TIME_TO_LIVE_S

    def set_axis(self, name: str, position: float, turn: int) -> None:
        """Turn the head towards `position`; 1 is all the way to the left."""
        if name in self.limits.axes and self._fence.admits(turn):
            self._pan_target_rad = unit(position) * PAN_LIMIT_RAD

    def control(self, name: str, value: ControlValue, turn: int) -> None:
        """Set a control; impossible values are clipped or ignored."""
        if not self._fence.admits(turn):
            return
        lamp = self._senses.lamp
        if name == "lamp":
            lamp = replace(lamp, is_on=value is True)
        elif name == "brightness" and isinstance(value, int | float):
            lamp = replace(lamp, brightness=min(FULL, max(0.0, value)))
        elif name == "light" and isinstance(value, str) and value in LIGHTS:
            lamp = replace(lamp, light=value)
        elif name == "look_around":
            self._is_looking_around = value is True
        is_honking = value is True if name == "horn" else self._senses.is_honking
        self._senses = replace(self._senses, lamp=lamp, is_honking=is_honking)

    def stop(self, turn: int) -> None:
        """Brake, whatever the turn, and stop everything that a control has set in motion."""
        self._fence.admits(turn)
        self._target = STANDSTILL
        self._is_looking_around = False

    def _let_go(self) -> None:
        self._target = STANDSTILL
        self._is_looking_around = False
        self._senses = replace(self._senses, is_honking=False)

    def advance(self, now_s: float) -> Senses:
        """Simulate in whole steps up to `now_s`; an earlier time has no effect."""
        start_s = self._senses.at_s
        steps = int(min(now_s - start_s, MAX_CATCH_UP_S) / STEP_S + 1e-6)
        for number in range(1, steps + 1):
            self._step(start_s + number * STEP_S)
        if now_s - start_s > MAX_CATCH_UP_S:
            self._senses = replace(self._senses, at_s=now_s)
        return self._senses

    def _step(self, at_s: float) -> None:
        if at_s >= self._expires_s:
            self._let_go()
        target = self._target
        if self._is_looking_around:
            target = within(replace(target, angular_rps=LOOK_AROUND_RPS), self.limits)
        moved = step(self._motion, target, self.limits, self._world, STEP_S)
        self._motion = moved
        twist = Twist(moved.linear_mps, moved.angular_rps, moved.lateral_mps)
        wheels = tuple(self._wheels.speeds_mps(twist).values())
        bumped = moved.impact_mps > THUD_MPS
        before = self._senses
        most = PAN_SPEED_RPS * STEP_S
        pan = before.pan_rad + min(most, max(-most, self._pan_target_rad - before.pan_rad))
        warmed = _WARMING_C_PER_M * max(map(abs, wheels)) * STEP_S
        cooled = (before.motor_c - ROOM_C) * STEP_S / _COOLING_S
        self._senses = replace(
            before,
            at_s=at_s,
            pose=moved.pose,
            pan_rad=pan,
            twist=twist,
            wheels_mps=wheels,
            bumps=before.bumps + bumped,
            bump_mps=moved.impact_mps if bumped else before.bump_mps,
            motor_c=before.motor_c + warmed - cooled,
        )
