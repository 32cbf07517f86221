"""What a robot tells of itself: a field and a record for each value.

The status, the messages to pages, the tape, home automation, the metrics and the page's details all
follow `ROBOT_VALUES`. A driver reports a value that `RobotState` has no field for as a gauge with
the value's name.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from pydantic import BaseModel

if TYPE_CHECKING:
    from collections.abc import Mapping


class RobotReport(BaseModel):
    """The values as pages and the tape have them, null if the robot does not report one."""

    bumpers: int = 0
    """A bit for each pressed bumper."""
    battery_v: float | None = None
    battery_fraction: float | None = None
    """0 (empty) to 1 (full)."""


@dataclass(frozen=True, slots=True)
class HouseSensor:
    """A sensor of home automation: its topic, its English name, and Home Assistant's keys."""

    topic: str
    name: str
    keys: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class RobotNumber:
    """How people read a number: multiplied by `factor`, with `decimals` and `unit`.

    `words` is the code of its name in the page's words; numbers with the same code share a line.
    Pages and the tape get it with `sent_decimals`, with all if None.
    """

    words: str
    unit: str
    factor: float = 1.0
    decimals: int = 1
    sent_decimals: int | None = None
    is_replayed: bool = True
    """Whether `wax replay` shows it."""
    sensor: HouseSensor | None = None
    metric: tuple[str, str] | None = None
    """The metric of Prometheus and its description; its value is as the robot reports it."""


ROBOT_VALUES: Final[Mapping[str, RobotNumber | None]] = {
    "bumpers": None,
    "battery_fraction": RobotNumber(
        "facts.battery",
        "%",
        factor=100.0,
        decimals=0,
        is_replayed=False,
        sensor=HouseSensor(
            "battery", "Battery", {"device_class": "battery", "unit_of_measurement": "%"}
        ),
        metric=("wax_battery_ratio", "What is left in the robot's battery"),
    ),
    "battery_v": RobotNumber("facts.battery", "V", sent_decimals=1),
}
"""Each value by its name everywhere, with its record if it is a number that people read."""

ROBOT_NUMBERS: Final = {name: one for name, one in ROBOT_VALUES.items() if one is not None}

HOUSE_SENSORS: Final = [one.sensor for one in ROBOT_NUMBERS.values() if one.sensor is not None]


def report(told: Mapping[str, float | None]) -> dict[str, Any]:
    """Return the fields of a `RobotReport`: finite values, rounded as they are sent."""
    return {name: _sent(one, told.get(name)) for name, one in ROBOT_VALUES.items()}


def _sent(number: RobotNumber | None, value: float | None) -> float | None:
    if value is None or not math.isfinite(value):
        return None
    decimals = None if number is None else number.sent_decimals
    return value if decimals is None else round(value, decimals)
