"""Converts the robot's messages to a robot state (pure).

A message has the attributes of the ROS 2 message, whether it came by DDS or as JSON.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

from wax.driver.interface import Pose, Reading
from wax.robot.ros2 import members

if TYPE_CHECKING:
    from collections.abc import Mapping

ODOMETRY_S: Final = 1.0
"""Odometry older than this is expired."""
FAULT_S: Final = 10.0
"""A fault expires after this without a repeat; diagnostics come about once a second."""
MOVES_MPS: Final = 0.01
MOVES_RPS: Final = 0.02
"""A slower turn is the odometry noise of a standing robot."""
_ERROR: Final = 2
_BUMP: Final = 1
_SOME_BUMPER: Final = 7
"""The bit for a bumper whose place is not reported."""
_UNREADABLE: Final = "?"
_LEAST_LENGTH: Final = 0.5
"""The shortest accepted quaternion; a rotation has the length 1."""
_MAX_WORDS: Final = 200
_MAX_STATUSES: Final = 256
_NO_MESSAGE: Final = (AttributeError, TypeError, ValueError, OverflowError, IndexError)
"""What reading an invalid message raises; `IndexError` is for an empty octet."""


class RosSenses:
    """Keeps the newest message of each kind; invalid ones never raise."""

    def __init__(self) -> None:
        self._pose: Pose | None = None
        self._moving: bool | None = None
        self._told_s = -math.inf
        self._faults: dict[str, tuple[str, float]] = {}
        self.bumpers = 0
        self.battery_v: float | None = None
        self.battery_fraction: float | None = None
        self.invalid = 0
        self._is_strange = False

    def handle_message(self, kind: str, message: Any, now_s: float) -> None:
        """Handle a message of ``odometry``, ``battery``, ``bumper`` or ``diagnostics``.

        Each member counts by itself: a missing or invalid one does not affect the others. Messages
        with such members are counted.
        """
        self._is_strange = False
        try:
            self._hear[kind](self, message, now_s)
        except _NO_MESSAGE:
            self._is_strange = True
        self.invalid += self._is_strange

    def reading(self, now_s: float) -> Reading:
        """Return all that the robot tells but its faults."""
        return Reading(
            moving=self.moving(now_s),
            pose=self.pose(now_s),
            bumpers=self.bumpers,
            battery_v=self.battery_v,
            battery_fraction=self.battery_fraction,
            extra={"ros2_invalid": float(self.invalid)},
        )

    def pose(self, now_s: float) -> Pose | None:
        return self._pose if now_s - self._told_s < ODOMETRY_S else None

    def moving(self, now_s: float) -> bool | None:
        return self._moving if now_s - self._told_s < ODOMETRY_S else None

    def fault(self, now_s: float) -> str | None:
        """Return the newest fault that has not expired, as ``name: message``."""
        fresh = [(at_s, said) for said, at_s in self._faults.values() if now_s - at_s < FAULT_S]
        return max(fresh)[1] if fresh else None

    def _odometry(self, message: Any, now_s: float) -> None:
        number = self._number
        placed, moved = "pose.covariance", "twist.covariance"
        x_m = (
            None if self._is_denied(message, placed, 0) else number(message, "pose.pose.position.x")
        )
        y_m = (
            None if self._is_denied(message, placed, 7) else number(message, "pose.pose.position.y")
        )
        heading = None if self._is_denied(message, placed, 35) else self._heading(message)
        speeds = (
            ("linear.x", 0, MOVES_MPS),
            ("linear.y", 7, MOVES_MPS),
            ("angular.z", 35, MOVES_RPS),
        )
        told = [
            (number(message, f"twist.twist.{name}"), least)
            for name, variance, least in speeds
            if not self._is_denied(message, moved, variance)
        ]
        known = [(value, least) for value, least in told if value is not None]
        if any(abs(value) > least for value, least in known):
            self._moving = True
        else:
            self._moving = False if len(known) == len(speeds) else None
        self._pose = (
            None if x_m is None or y_m is None or heading is None else Pose(x_m, y_m, heading)
        )
        self._told_s = now_s

    def _heading(self, message: Any) -> float | None:
        parts = [self._number(message, f"pose.pose.orientation.{name}") for name in "xyzw"]
        known = [part for part in parts if part is not None]
        # All zeros, from a driver without orientation, is not a rotation.
        if len(known) < len(parts) or math.hypot(*known) < _LEAST_LENGTH:
            return None
        x, y, z, w = (part / math.hypot(*known) for part in known)
        return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))

    def _battery(self, message: Any, _: float) -> None:
        volts, share = self._number(message, "voltage"), self._number(message, "percentage")
        # A driver that does not measure leaves 0 V. Some send percent instead of a fraction.
        share = share / 100.0 if share is not None and share > 1.0 else share
        self.battery_v = volts if volts is not None and volts > 0.0 else None
        self.battery_fraction = share if share is not None and 0.0 <= share <= 1.0 else None

    def _bumper(self, message: Any, _: float) -> None:
        if hasattr(message, "detections"):
            kinds = [self._number(found, "type") for found in _list(message.detections)]
            self.bumpers = int(_BUMP in kinds)
        elif hasattr(message, "state"):
            number, state = self._number(message, "bumper"), self._number(message, "state")
            bit = 1 << (_SOME_BUMPER if number is None else min(7, max(0, int(number))))
            if state is not None:
                self.bumpers = self.bumpers | bit if state else self.bumpers & ~bit
        else:
            self.bumpers = int(_truth(message.data))

    def _diagnostics(self, message: Any, now_s: float) -> None:
        self._faults = {
            name: told for name, told in self._faults.items() if now_s - told[1] < FAULT_S
        }
        for status in _list(message.status)[:_MAX_STATUSES]:
            try:
                level = _octet(status.level)
            except _NO_MESSAGE:
                self._is_strange = True
                continue
            name, words = self._text(status, "name"), self._text(status, "message")
            if level == _ERROR and len(self._faults) < _MAX_STATUSES:
                self._faults[name] = (f"{name}: {words}"[:_MAX_WORDS], now_s)
            else:
                self._faults.pop(name, None)

    def _number(self, message: Any, path: str) -> float | None:
        """Return a number, None if it is unknown: NaN, which is null in JSON, or not a number."""
        value = message
        try:
            for name in path.split("."):
                value = getattr(value, name)
            number = math.nan if value is None else float(members.number(value))
        except _NO_MESSAGE:
            number = math.inf
        self._is_strange = self._is_strange or math.isinf(number)
        return number if math.isfinite(number) else None

    def _is_denied(self, message: Any, path: str, place: int) -> bool:
        """Whether a negative variance marks its value as not measured, as is usual in ROS."""
        try:
            part, name = path.split(".")
            return bool(members.number(getattr(getattr(message, part), name)[place]) < 0.0)
        except _NO_MESSAGE:
            return False  # many drivers omit it or send NaN

    def _text(self, message: Any, name: str) -> str:
        try:
            return members.text(getattr(message, name))
        except _NO_MESSAGE:
            self._is_strange = True
            return _UNREADABLE

    _hear: Final[Mapping[str, Any]] = {
        "odometry": _odometry,
        "battery": _battery,
        "bumper": _bumper,
        "diagnostics": _diagnostics,
    }


def _list(value: Any) -> Any:
    if not isinstance(value, Sequence) or isinstance(value, str):
        raise TypeError("not a list")
    return value


def _octet(value: Any) -> int:
    """Return an octet: a number in DDS, but in JSON perhaps a character or base64."""
    if isinstance(value, str):
        value = value.encode("latin-1") if len(value) == 1 else base64.b64decode(value)
    return int(value[0] if isinstance(value, bytes) else value)


def _truth(value: object) -> bool:
    if not isinstance(value, bool):
        raise TypeError("not true or false")
    return value
