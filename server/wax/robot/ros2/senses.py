"""What the robot tells, from messages to a state (pure).

A message has the attributes of the ROS 2 message, whether it came by DDS or as JSON.
"""

from __future__ import annotations

import base64
import math
from typing import TYPE_CHECKING, Any, Final

from wax.driver.interface import Pose
from wax.robot.ros2 import members

if TYPE_CHECKING:
    from collections.abc import Mapping

ODOMETRY_S: Final = 1.0
"""Odometry that is older says nothing about now."""
FAULT_S: Final = 10.0
"""Diagnostics come about once a second; whoever told of a fault and is gone holds nobody."""
MOVES_MPS: Final = 0.01
MOVES_RPS: Final = 0.02
"""Below that it is the noise of a standing robot's odometry."""
_ERROR: Final = 2
_BUMP: Final = 1
_MAX_WORDS: Final = 200
_MAX_STATUSES: Final = 256
_NO_MESSAGE: Final = (AttributeError, TypeError, ValueError, OverflowError, IndexError)
"""What reading one raises; `IndexError` is for an octet of nothing."""


class Senses:
    """Keeps the newest of each kind; `hear` raises `ValueError` for what is no such message."""

    def __init__(self) -> None:
        self._pose: Pose | None = None
        self._moving: bool | None = None
        self._told_s = -math.inf
        self._faults: dict[str, tuple[str, float]] = {}
        self.bumpers = 0
        self.battery_v: float | None = None
        self.battery_fraction: float | None = None
        self.invalid = 0

    def hear(self, kind: str, message: Any, now_s: float) -> None:
        """Take a message of ``odometry``, ``battery``, ``bumper`` or ``diagnostics``.

        What is no such message, as JSON may be, changes nothing and is counted.
        """
        try:
            self._hear[kind](self, message, now_s)
        except _NO_MESSAGE:
            self.invalid += 1

    def pose(self, now_s: float) -> Pose | None:
        return self._pose if now_s - self._told_s < ODOMETRY_S else None

    def moving(self, now_s: float) -> bool | None:
        return self._moving if now_s - self._told_s < ODOMETRY_S else None

    def fault(self, now_s: float) -> str | None:
        """Return the newest fault that is still told, as ``name: message``."""
        fresh = [(at_s, said) for said, at_s in self._faults.values() if now_s - at_s < FAULT_S]
        return max(fresh)[1] if fresh else None

    def _odometry(self, message: Any, now_s: float) -> None:
        place, turned = message.pose.pose.position, message.pose.pose.orientation
        speed = message.twist.twist
        x, y, z, w = _finite(turned.x, turned.y, turned.z, turned.w)
        x_m, y_m = _finite(place.x, place.y)
        ahead, aside, turning = _finite(speed.linear.x, speed.linear.y, speed.angular.z)
        heading = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        self._pose = Pose(x_m=x_m, y_m=y_m, heading_rad=heading)
        self._moving = math.hypot(ahead, aside) > MOVES_MPS or abs(turning) > MOVES_RPS
        self._told_s = now_s

    def _battery(self, message: Any, _: float) -> None:
        volts, share = float(message.voltage), float(message.percentage)
        # Not known is NaN. Some drivers say percents where the message asks for a share.
        share = share / 100.0 if share > 1.0 else share
        self.battery_v = volts if math.isfinite(volts) else None
        self.battery_fraction = share if 0.0 <= share <= 1.0 else None

    def _bumper(self, message: Any, _: float) -> None:
        if hasattr(message, "detections"):
            self.bumpers = int(any(found.type == _BUMP for found in message.detections))
        elif hasattr(message, "state"):
            bit = 1 << min(7, max(0, int(message.bumper)))
            self.bumpers = self.bumpers | bit if message.state else self.bumpers & ~bit
        else:
            self.bumpers = int(_truth(message.data))

    def _diagnostics(self, message: Any, now_s: float) -> None:
        self._faults = {
            name: told for name, told in self._faults.items() if now_s - told[1] < FAULT_S
        }
        for status in message.status[:_MAX_STATUSES]:
            name = members.text(status.name)
            if _octet(status.level) == _ERROR and len(self._faults) < _MAX_STATUSES:
                said = f"{name}: {members.text(status.message)}"[:_MAX_WORDS]
                self._faults[name] = (said, now_s)
            else:
                self._faults.pop(name, None)

    _hear: Final[Mapping[str, Any]] = {
        "odometry": _odometry,
        "battery": _battery,
        "bumper": _bumper,
        "diagnostics": _diagnostics,
    }


def _finite(*numbers: object) -> list[float]:
    found = [float(number) for number in numbers]  # type: ignore[arg-type]  # it raises for others
    if not all(math.isfinite(number) for number in found):
        raise ValueError("not a number")
    return found


def _octet(value: Any) -> int:
    """Return an octet, which is a number in DDS; in JSON it may be a character or base64."""
    if isinstance(value, str):
        value = value.encode("latin-1") if len(value) == 1 else base64.b64decode(value)
    return int(value[0] if isinstance(value, bytes) else value)


def _truth(value: object) -> bool:
    if not isinstance(value, bool):
        raise TypeError("not true or false")
    return value
