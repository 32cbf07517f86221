"""The robot's controls and gauges as pages see them. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from wax.control import gauge_limits
from wax.protocol import messages

if TYPE_CHECKING:
    from collections.abc import Iterable

    from wax.config.controls import ControlSettings, GaugeSettings
    from wax.control.gauge_limits import Level
    from wax.driver.interface import RobotState

InfoT = TypeVar("InfoT", messages.ControlInfo, messages.GaugeInfo)


def controls(settings: Iterable[ControlSettings]) -> list[messages.ControlInfo]:
    """Return what a page needs to show the controls."""
    return [_labelled(messages.ControlInfo, one) for one in settings]


def gauges(settings: Iterable[GaugeSettings]) -> list[messages.GaugeInfo]:
    """Return what a page needs to show the gauges."""
    return [_labelled(messages.GaugeInfo, one) for one in settings]


def _labelled(info: type[InfoT], one: ControlSettings | GaugeSettings) -> InfoT:
    """Return the keys that a page is told, by their names; one without a label has its name."""
    told = info.model_validate(one, from_attributes=True)
    return told.model_copy(update={"label": one.label or one.name})


def gauge_values(settings: Iterable[GaugeSettings], state: RobotState) -> dict[str, float]:
    """Return the values of the gauges that the robot reports, rounded as shown."""
    values = ((one, gauge_limits.value(one, state)) for one in settings)
    return {one.name: round(value, one.decimals) for one, value in values if value is not None}


def beyond(settings: Iterable[GaugeSettings], state: RobotState) -> dict[str, Level]:
    """Return the gauges beyond a limit; none while the robot is not connected."""
    if not state.connected:
        return {}
    levels = ((one, gauge_limits.level(one, gauge_limits.value(one, state))) for one in settings)
    return {one.name: level for one, level in levels if level is not None}
