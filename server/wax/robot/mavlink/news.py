"""What a rover tells, in our units and directions: x forward or north, y to the left of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

AUTOPILOT: Final = 1
"""MAV_COMP_ID_AUTOPILOT1, whichever system it is of."""


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
    """None is not known: the rover has no estimate."""

    mps: float | None


@dataclass(frozen=True, slots=True)
class Attitude:
    """The heading, how fast it changes, and how long ago the rover was switched on.

    None is not known.
    """

    heading_rad: float | None
    turn_rps: float | None
    boot_ms: int


@dataclass(frozen=True, slots=True)
class Position:
    """None is not known."""

    x_m: float | None
    y_m: float | None


@dataclass(frozen=True, slots=True)
class Battery:
    """What is None is not measured."""

    volts: float | None
    fraction: float | None


News = Heartbeat | Parameter | Speed | Attitude | Position | Battery


@dataclass(frozen=True, slots=True)
class HeardMessage:
    """A message with its sender; `news` is None for one that does not matter to us."""

    system: int
    component: int
    news: News | None
    is_signed: bool = False
