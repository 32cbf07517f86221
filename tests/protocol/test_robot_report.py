"""The values that a robot tells of itself."""

from __future__ import annotations

import math

from wax.driver.interface import RobotState
from wax.protocol.messages import RobotStatus
from wax.protocol.robot_report import ROBOT_VALUES, RobotReport, report
from wax.protocol.tape_events import Reported


def test_each_value_has_a_field() -> None:
    """The list and the fields of pages and tape have the same names."""
    assert RobotReport.model_fields.keys() == ROBOT_VALUES.keys()
    assert RobotReport.model_fields.keys() <= RobotStatus.model_fields.keys()
    assert RobotReport.model_fields.keys() <= Reported.model_fields.keys()


def test_values_are_finite_and_as_precise_as_they_are_sent() -> None:
    """A voltage has one decimal, a fraction all, and NaN is unknown."""
    unknown = dict.fromkeys(ROBOT_VALUES) | {"bumpers": 0}
    told = RobotState(connected=True, bumpers=2, battery_v=7.46, battery_fraction=0.615).told
    known = {"bumpers": 2, "battery_v": 7.5, "battery_fraction": 0.615}
    assert report(told) == unknown | known
    told = RobotState(connected=True, battery_v=math.nan, battery_fraction=math.inf).told
    assert report(told) == unknown


def test_a_value_may_be_among_the_gauges() -> None:
    """A driver reports further values by name; a field of the state outranks a gauge."""
    state = RobotState(connected=True, battery_v=7.0, gauges={"battery_v": 6.0, "motor_c": 40.0})
    assert state.told["motor_c"] == 40.0
    assert state.told["battery_v"] == 7.0
