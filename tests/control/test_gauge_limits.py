"""When a gauge warns, and when it stops the robot."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.config.controls import GaugeSettings
from wax.control import gauge_limits
from wax.control.gauge_limits import WELL_S, GaugeHold, Level
from wax.driver.interface import RobotState

HEAT = GaugeSettings(name="heat", label="Motors", unit="°C", warn_above=60.0, stop_above=80.0)
BATTERY = GaugeSettings(name="battery_v", warn_below=11.0, stop_below=10.0, stop_above=20.0)
SPEED = GaugeSettings(name="speed")


def told(**gauges: float) -> RobotState:
    return RobotState(connected=True, gauges=gauges)


@pytest.mark.parametrize(
    ("gauge", "value", "level"),
    [
        (HEAT, 60.0, None),
        (HEAT, 60.1, "warn"),
        (HEAT, 80.0, "warn"),
        (HEAT, 80.1, "stop"),
        (BATTERY, 11.0, None),
        (BATTERY, 10.9, "warn"),
        (BATTERY, 10.0, "warn"),
        (BATTERY, 9.9, "stop"),
        (BATTERY, 20.1, "stop"),
        (HEAT, None, "stop"),
        (SPEED, None, None),
        (SPEED, 1e9, None),
    ],
)
def test_levels(gauge: GaugeSettings, value: float | None, level: Level | None) -> None:
    """A value at its limit is still within; a missing value that could stop does stop."""
    assert gauge_limits.level(gauge, value) == level


@pytest.mark.parametrize(
    ("state", "value"),
    [
        (told(battery_v=12.0), 12.0),
        (RobotState(connected=True, battery_v=12.5), 12.5),
        (RobotState(connected=True, battery_v=12.5, gauges={"battery_v": 11.0}), 11.0),
        (told(battery_v=math.nan), None),
        (told(battery_v=math.inf), None),
        (told(heat=5.0), None),
    ],
)
def test_what_a_gauge_shows(state: RobotState, value: float | None) -> None:
    """A gauge shows the driver's value or its battery state, but never NaN or infinity."""
    assert gauge_limits.value(BATTERY, state) == value


def test_the_battery_may_be_a_fraction() -> None:
    """The battery's fraction is a gauge as well."""
    left = GaugeSettings(name="battery_fraction", max=1.0, stop_below=0.1)
    state = RobotState(connected=True, battery_v=12.0, battery_fraction=0.05)
    assert gauge_limits.value(left, state) == 0.05


@pytest.mark.parametrize(
    ("gauge", "state", "said"),
    [
        (HEAT, told(heat=81.0), "Motors is above 80 °C: nobody can drive until it is back."),
        (BATTERY, told(battery_v=9.5), "battery_v is below 10: nobody can drive until it is back."),
        (BATTERY, told(battery_v=21), "battery_v is above 20: nobody can drive until it is back."),
        (HEAT, told(), "The robot does not report “Motors”, which must be known to drive."),
    ],
)
def test_why_it_stops(gauge: GaugeSettings, state: RobotState, said: str) -> None:
    """The sentence names the gauge and its limit, but not its ever-changing value."""
    assert str(gauge_limits.update(GaugeHold(), [SPEED, gauge], state, 5.0).reason) == said


def test_a_number_at_its_limit_does_not_stop_again_and_again() -> None:
    """A stopped robot stays stopped until all gauges have been fine for `WELL_S`."""
    hold = gauge_limits.update(GaugeHold(), [HEAT], told(heat=81.0), 10.0)
    assert hold.reason
    hold = gauge_limits.update(hold, [HEAT], told(heat=70.0), 10.1)
    assert hold.reason
    hold = gauge_limits.update(hold, [HEAT], told(heat=81.0), 11.0)
    hold = gauge_limits.update(hold, [HEAT], told(heat=70.0), 10.9 + WELL_S)
    assert hold.reason
    hold = gauge_limits.update(hold, [HEAT], told(heat=70.0), 11.0 + WELL_S)
    assert hold.reason is None


def test_a_robot_that_is_not_there_tells_nothing_new() -> None:
    """A disconnected robot is not held by a gauge, unless one held it before."""
    away = RobotState(connected=False)
    assert gauge_limits.update(GaugeHold(), [HEAT], away, 1.0).reason is None
    hot = gauge_limits.update(GaugeHold(), [HEAT], told(heat=90.0), 1.0)
    assert gauge_limits.update(hot, [HEAT], away, 100.0) == hot


@given(st.lists(st.tuples(st.floats(0, 3), st.floats()), max_size=30))
def test_driven_only_where_all_was_well(trace: list[tuple[float, float]]) -> None:
    """The robot is free only if no value of the last `WELL_S` was beyond a limit."""
    now_s, hold, ill_s = 0.0, GaugeHold(), -math.inf
    for gap_s, heat in trace:
        now_s += gap_s
        hold = gauge_limits.update(hold, [HEAT], told(heat=heat), now_s)
        if not heat <= 80.0 or math.isinf(heat):
            ill_s = now_s
        assert (hold.reason is None) is (now_s - ill_s >= WELL_S)
