"""A rover's reports in our units and directions: x is forward or north, y to the left of that."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

AUTOPILOT: Final = 1
"""MAV_COMP_ID_AUTOPILOT1, the autopilot of any system."""


@dataclass(frozen=True, slots=True)
class Heartbeat:
    """`kind` is MAV_TYPE, `autopilot` MAV_AUTOPILOT, `mode` the autopilot's own number."""

    kind: int
    autopilot: int
    mode: int
    is_armed: bool


@dataclass(frozen=True, slots=True)
class Parameter:
    name: str
    value: float


@dataclass(frozen=True, slots=True)
class Speed:
    """A value is None if the rover has no estimate."""

    mps: float | None


@dataclass(frozen=True, slots=True)
class Attitude:
    """The heading, its rate, and the time since the rover was switched on; None if unknown."""

    heading_rad: float | None
    turn_rps: float | None
    boot_ms: int


@dataclass(frozen=True, slots=True)
class Position:
    """A value is None if unknown."""

    x_m: float | None
    y_m: float | None


@dataclass(frozen=True, slots=True)
class Battery:
    """A value is None if not measured."""

    volts: float | None
    fraction: float | None


News = Heartbeat | Parameter | Speed | Attitude | Position | Battery


@dataclass(frozen=True, slots=True)
class HeardMessage:
    """A message with its sender; `news` is None if the message does not matter to us."""

    system: int
    component: int
    news: News | None
    is_signed: bool = False
