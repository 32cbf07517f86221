"""The configuration, converted to the units of control."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import TYPE_CHECKING

import pytest

from wax.config.drive import DriveSettings
from wax.config.local import LocalSettings
from wax.config.robot import RobotSettings
from wax.control.local_hand import HandRules
from wax.control.rules import Rules
from wax.driver.interface import Limits

if TYPE_CHECKING:
    from wax.config.bases import Base

DRIVE = DriveSettings(
    loop_hz=40.0,
    max_age_ms=120.0,
    max_command_age_ms=450.0,
    slow_picture_age_ms=300.0,
    stop_picture_age_ms=700.0,
    max_stop_distance_m=0.7,
)
ROBOT = RobotSettings(
    silence_ms=150,
    max_linear_acceleration_mps2=1.2,
    max_angular_acceleration_rps2=5.0,
    soft_braking=True,
    braking_mps2=2.5,
    wheel_base_m=0.4,
)
LIMITS = Limits(0.6, 1.5, ttl_s=0.2)


def test_rules_are_in_the_units_of_control() -> None:
    """Milliseconds become seconds, a rate a period, and the wheels' braking the body's."""
    rules = Rules.of(DRIVE, ROBOT, LIMITS)
    assert rules == replace(
        rules,
        limits=LIMITS,
        max_age_s=0.12,
        max_command_age_s=0.45,
        slow_picture_age_s=0.3,
        stop_picture_age_s=0.7,
        period_s=0.025,
        silence_s=0.15,
        watchdog_s=0.2,
        acceleration_mps2=1.2,
        acceleration_rps2=5.0,
        braking_rps2=12.5,
    )


@pytest.mark.parametrize(
    ("base", "expected_rps2"), [("differential", 12.5), ("mecanum", 5.0), ("omni", 10.0)]
)
def test_a_base_brakes_its_turning_at_its_own_lever(base: Base, expected_rps2: float) -> None:
    """Operator and person aboard slow down a turn as fast as this base's wheels brake."""
    sizes = {"base": base, "axle_base_m": 0.6, "omni_radius_m": 0.25}
    robot = ROBOT.model_copy(update=sizes)
    hand = HandRules.of(LocalSettings(), robot, 0.02)
    assert Rules.of(DRIVE, robot, LIMITS).braking_rps2 == hand.braking_rps2 == expected_rps2


def test_a_rule_that_is_a_key_has_its_value() -> None:
    """What is called in control as in the configuration is the same number."""
    keys = DRIVE.model_dump() | ROBOT.model_dump()
    rules = Rules.of(DRIVE, ROBOT, LIMITS)
    alike = {one.name for one in fields(rules)} & keys.keys()
    assert {name: getattr(rules, name) for name in alike} == {name: keys[name] for name in alike}


@pytest.mark.parametrize(("ttl_s", "expected_s"), [(None, 0.15), (0.1, 0.15), (0.2, 0.2)])
def test_the_slowest_watchdog_that_is_known(ttl_s: float | None, expected_s: float) -> None:
    """The driver process's timeout always counts, the robot's own only if known."""
    limits = Limits(0.6, 1.5, ttl_s=ttl_s)
    assert Rules.of(DRIVE, ROBOT, limits).watchdog_s == expected_s
