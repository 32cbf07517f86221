"""The room's state for home automation, by the last level of each topic. Pure."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from wax.house.commands import OFF, ON
from wax.house.discovery import DRIVER, gauge_key
from wax.house.house import UNKNOWN
from wax.protocol.host_switches import SWITCHES
from wax.protocol.robot_report import ROBOT_NUMBERS

if TYPE_CHECKING:
    from collections.abc import Iterable

    from wax.config.controls import GaugeSettings
    from wax.protocol.messages import RoomState


def house_states(
    room: RoomState, gauges: Iterable[GaugeSettings], *, is_open: bool, names: bool
) -> dict[str, str]:
    """Return each state as text; without `names` the driver's name is empty.

    The empty text deletes a name that the broker retains from before.
    """
    driver = ""
    if names:
        drives = (one.name for one in room.viewers if one.id == room.turn.operator)
        driver = next(drives, UNKNOWN)
    states = {
        DRIVER: driver,
        "queue": str(sum(one.role == "queued" for one in room.viewers)),
        "viewers": str(len(room.viewers)),
        "open": ON if is_open else OFF,
    }
    for switch in SWITCHES.values():
        if switch.at_home and switch.told:
            is_on = getattr(room.host_settings, switch.told)
            states[switch.at_home.topic] = ON if is_on else OFF
    for name, number in ROBOT_NUMBERS.items():
        if number.sensor is not None:
            told = getattr(room.robot, name)
            known = math.nan if told is None else told * number.factor
            states[number.sensor.topic] = _number(known, number.decimals)
    for gauge in gauges:
        value = room.robot.gauges.get(gauge.name, math.nan)
        states[gauge_key(gauge.name)] = _number(value, gauge.decimals)
    return states


def _number(value: float, decimals: int) -> str:
    return f"{value:.{decimals}f}" if math.isfinite(value) else UNKNOWN
