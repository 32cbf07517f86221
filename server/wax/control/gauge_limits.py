"""Which of the robot's gauges are beyond a limit, and when that stops the robot. Pure.

A gauge with a stopping limit also stops the robot when its value is missing or not a number. The
robot stays stopped until all gauges have been fine for `WELL_S`, so that a value hovering at its
limit, such as a weak battery's voltage, does not stop it again and again.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from wax.protocol.robot_report import ROBOT_NUMBERS
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Iterable

    from wax.config.controls import GaugeSettings
    from wax.driver.interface import RobotState

WELL_S: Final = 2.0

Level = Literal["warn", "stop"]


@dataclass(frozen=True, slots=True)
class GaugeHold:
    """Why a gauge holds the robot, None if none does; `ill_s` is when one last passed a limit."""

    reason: Sentence | None = None
    ill_s: float = -math.inf


def value(gauge: GaugeSettings, state: RobotState) -> float | None:
    """Return the value that the robot reports, None if it reports no number."""
    told = state.gauges.get(gauge.name)
    if told is None and gauge.name in ROBOT_NUMBERS:
        told = state.told.get(gauge.name)
    return told if told is not None and math.isfinite(told) else None


def level(gauge: GaugeSettings, told: float | None) -> Level | None:
    """Return which limit of its gauge a value has passed, None if it is within them."""
    if told is None:
        return "stop" if gauge.may_stop else None
    if _is_beyond(told, gauge.stop_below, gauge.stop_above):
        return "stop"
    return "warn" if _is_beyond(told, gauge.warn_below, gauge.warn_above) else None


def update(
    hold: GaugeHold, gauges: Iterable[GaugeSettings], state: RobotState, now_s: float
) -> GaugeHold:
    """Return whether a gauge holds the robot now; a disconnected robot changes nothing."""
    if not state.connected:
        return hold
    for gauge in gauges:
        told = value(gauge, state)
        if level(gauge, told) == "stop":
            return GaugeHold(_reason(gauge, told), now_s)
    return hold if now_s - hold.ill_s < WELL_S else GaugeHold()


def _is_beyond(told: float, below: float | None, above: float | None) -> bool:
    return (below is not None and told < below) or (above is not None and told > above)


def _reason(gauge: GaugeSettings, told: float | None) -> Sentence:
    name = gauge.label or gauge.name
    if told is None:
        return Sentence("gauge.untold", {"name": name})
    unit = f" {gauge.unit}" if gauge.unit else ""
    if gauge.stop_below is not None and told < gauge.stop_below:
        return Sentence("gauge.below", {"name": name, "limit": gauge.stop_below, "unit": unit})
    assert gauge.stop_above is not None
    return Sentence("gauge.above", {"name": name, "limit": gauge.stop_above, "unit": unit})
