"""The robot's controls and gauges as pages see them. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.control import gauge_limits
from wax.protocol import messages

if TYPE_CHECKING:
    from collections.abc import Iterable

    from wax.config.controls import ControlSettings, GaugeSettings
    from wax.control.gauge_limits import Level
    from wax.driver.interface import RobotState


def controls(settings: Iterable[ControlSettings]) -> list[messages.ControlInfo]:
    """Return what a page needs to show the controls."""
    return [
        messages.ControlInfo(
            name=one.name,
            label=one.label or one.name,
            kind=one.kind,
            min=one.min,
            max=one.max,
            step=one.step,
            choices=one.choices,
            key=one.key,
            moves=one.moves,
            roles=one.roles,
        )
        for one in settings
    ]


def gauges(settings: Iterable[GaugeSettings]) -> list[messages.GaugeInfo]:
    """Return what a page needs to show the gauges."""
    return [
        messages.GaugeInfo(
            name=one.name,
            label=one.label or one.name,
            unit=one.unit,
            min=one.min,
            max=one.max,
            decimals=one.decimals,
        )
        for one in settings
    ]


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
