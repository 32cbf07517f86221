"""Converts between a robot's motion and the speeds of its wheels (pure)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from operator import mul
from typing import TYPE_CHECKING, Final

from wax.driver.checks import within
from wax.driver.interface import Limits, Pose, Twist

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.config.bases import Base
    from wax.config.robot import RobotSettings

MAX_WHEEL_MPS: Final = 32.767
"""The largest speed in a signed 16-bit number of mm/s."""


@dataclass(frozen=True, slots=True)
class _Wheel:
    """How fast a wheel rolls for each m/s ahead, m/s to the left, and m/s at the lever's end."""

    ahead: float
    left: float
    turn: float


_SIN_60: Final = math.sin(math.pi / 3.0)
_WHEELS: Final[dict[Base, dict[str, _Wheel]]] = {
    "differential": {"left": _Wheel(1.0, 0.0, -1.0), "right": _Wheel(1.0, 0.0, 1.0)},
    # Seen from above, the rollers form an X.
    "mecanum": {
        "front_left": _Wheel(1.0, -1.0, -1.0),
        "front_right": _Wheel(1.0, 1.0, 1.0),
        "back_left": _Wheel(1.0, 1.0, -1.0),
        "back_right": _Wheel(1.0, -1.0, 1.0),
    },
    # At 60° to the left and to the right of ahead, and at the back. Left and right are positive
    # where they drive ahead, as with two wheels; the back one is where it drives to the left.
    "omni": {
        "left": _Wheel(_SIN_60, -0.5, -1.0),
        "right": _Wheel(_SIN_60, 0.5, 1.0),
        "back": _Wheel(0.0, 1.0, -1.0),
    },
}


class WheelGeometry:
    """The wheels of a base: their `names`, in the order of all sequences, and where they are.

    A sign of `signs` is -1 for a wheel of an inverted side, else 1. If no `base` is given, it is
    that of the configuration; two sides of any base turn it as its own wheels do.
    """

    def __init__(self, settings: RobotSettings, base: Base | None = None) -> None:
        base = base or settings.base
        self.moves_sideways = base != "differential"
        self.names = tuple(_WHEELS[base])
        inverted = {"left": settings.invert_left, "right": settings.invert_right}
        self.signs = {name: -1.0 if inverted.get(_side(name)) else 1.0 for name in self.names}
        self._wheels = _WHEELS[base]
        self._lever_m = settings.lever_m

    def speeds_mps(self, twist: Twist) -> dict[str, float]:
        """Return how fast each wheel rolls, forward positive before any inversion."""
        aside_mps = twist.angular_rps * self._lever_m
        return {
            name: one.ahead * twist.linear_mps + one.left * twist.lateral_mps + one.turn * aside_mps
            for name, one in self._wheels.items()
        }

    def fastest_mps(self, limits: Limits) -> float:
        """Return the speed of the fastest wheel at the limits, moving straight or on the spot."""
        straight_mps = max(
            math.hypot(one.ahead * limits.linear_mps, one.left * limits.lateral_mps)
            for one in self._wheels.values()
        )
        return max(straight_mps, limits.angular_rps * self._lever_m)

    def motion(self, rolled: Sequence[float]) -> Twist:
        """Return the motion of the robot's middle that fits its wheels' best (least squares).

        `rolled` is in metres for a motion in metres and radians, in m/s for one in m/s and rad/s.
        """
        wheels = self._wheels.values()

        def part(shares: list[float]) -> float:
            square = sum(share * share for share in shares)
            told = sum(map(mul, shares, rolled))
            return told / square if square else 0.0

        return Twist(
            part([one.ahead for one in wheels]),
            part([one.turn for one in wheels]) / self._lever_m,
            part([one.left for one in wheels]),
        )

    def moved(self, pose: Pose, rolled_m: Sequence[float]) -> Pose:
        """Return the pose after the wheels have rolled that far, each at a constant speed."""
        by = self.motion(rolled_m)
        # Moving straight along the mean heading is exact to third order.
        middle_rad = pose.heading_rad + by.angular_rps / 2.0
        cos, sin = math.cos(middle_rad), math.sin(middle_rad)
        return Pose(
            pose.x_m + by.linear_mps * cos - by.lateral_mps * sin,
            pose.y_m + by.linear_mps * sin + by.lateral_mps * cos,
            math.remainder(pose.heading_rad + by.angular_rps, math.tau),
        )


class WheelMixer:
    """Converts a twist to wheel speeds for the robot's geometry, trims and inversions.

    The fastest that a wheel turns is its speed straight in any direction, or on the spot, at the
    limits. If a motion needs more, all wheels are slowed by one factor, so that a curve keeps its
    radius. A side's trim and inversion apply to all its wheels; the back one of an omni base has
    neither.
    """

    def __init__(self, settings: RobotSettings, base: Base | None = None) -> None:
        self.geometry = WheelGeometry(settings, base)
        self._limits = Limits(
            settings.max_linear_mps, settings.max_angular_rps, lateral_mps=settings.lateral_mps
        )
        self.fastest_mps = self.geometry.fastest_mps(self._limits)
        self._max_wheel_mps = min(MAX_WHEEL_MPS, self.fastest_mps)
        trims = {"left": settings.left_trim, "right": settings.right_trim}
        self._gains = {
            name: math.copysign(trims.get(_side(name), 1.0), sign)
            for name, sign in self.geometry.signs.items()
        }

    def mix(self, twist: Twist) -> dict[str, float]:
        """Return each wheel's speed in m/s, trimmed and inverted; NaN gives standstill."""
        speeds = self.geometry.speeds_mps(within(twist, self._limits))
        excess = max(1.0, *(abs(speed) / self._max_wheel_mps for speed in speeds.values()))
        return {name: speed / excess * self._gains[name] for name, speed in speeds.items()}


def _side(name: str) -> str:
    return name.rpartition("_")[2]
