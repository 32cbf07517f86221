"""How quickly the robot reaches the commanded speed."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.control.rules import RULES

from wax.control import ramp
from wax.control.gate import Setpoint
from wax.driver.interface import STANDSTILL, Twist
from wax.sentence import says

SOFT = replace(RULES, soft_braking=True)


@pytest.mark.parametrize(
    ("now_mps", "target_mps", "expected_mps", "expected_soft_mps"),
    [
        (0.0, 0.8, 0.1, 0.1),  # faster, at 1 m/s² for 0.1 s
        (0.0, -0.8, -0.1, -0.1),
        (0.75, 0.8, 0.8, 0.8),  # no further than the target
        (-0.75, -0.8, -0.8, -0.8),
        (0.8, 0.3, 0.3, 0.6),  # slower at once, or at 2 m/s²
        (-0.8, -0.3, -0.3, -0.6),
        (0.8, 0.7, 0.7, 0.7),
        (0.8, 0.0, 0.0, 0.6),
        (0.1, 0.0, 0.0, 0.0),
        (0.8, -0.8, -0.1, 0.6),  # through standstill: first slower, then faster
        (0.1, -0.8, -0.1, -0.05),
        (-0.1, 0.8, 0.1, 0.05),
        (0.1, -0.02, -0.02, -0.02),
        (0.8, 0.8, 0.8, 0.8),
        (0.0, 0.0, 0.0, 0.0),
    ],
)
def test_examples(
    now_mps: float, target_mps: float, expected_mps: float, expected_soft_mps: float
) -> None:
    """It speeds up at the acceleration, and slows down at once or, if soft, at the braking rate."""
    for rules, expected in ((RULES, expected_mps), (SOFT, expected_soft_mps)):
        # Turning has four times these rates, so four times the speeds make the same example.
        after = ramp.towards(
            Twist(target_mps, 4 * target_mps), Twist(now_mps, 4 * now_mps), 0.1, rules, soft=True
        )
        assert after.linear_mps == pytest.approx(expected)
        assert after.angular_rps == pytest.approx(4 * expected)


def test_what_is_not_soft_ends_at_once() -> None:
    """Stop, hand-over and faults end motion at once, even with soft braking."""
    assert ramp.towards(STANDSTILL, Twist(0.8, 2.0), 0.02, SOFT, soft=False) == STANDSTILL


@pytest.mark.parametrize(
    ("after_s", "expected_mps"), [(-1.0, 0.0), (0.0, 0.0), (0.01, 0.01), (0.04, 0.04), (0.2, 0.04)]
)
def test_step_by_the_clock(after_s: float, expected_mps: float) -> None:
    """A step is proportional to the time since the last one, up to two ticks."""
    target = Setpoint(Twist(0.8, 0.0), {"pan": 0.5}, limit=says("Slow."), soft=True)
    after = ramp.step(target, STANDSTILL, after_s, RULES)
    assert after.twist.linear_mps == pytest.approx(expected_mps)
    assert after == replace(target, twist=after.twist)


@pytest.mark.parametrize(("soft", "expected_mps"), [(True, 0.76), (False, 0.0)])
def test_step_is_as_soft_as_its_set_point(soft: bool, expected_mps: float) -> None:
    """The set-point decides whether motion ends softly."""
    after = ramp.step(Setpoint(reason=says("Why."), soft=soft), Twist(0.8, 0.0), 0.02, SOFT)
    assert after.twist.linear_mps == pytest.approx(expected_mps)


speeds = st.floats(-10, 10)


@given(now=speeds, target=speeds, after_s=st.floats(0, 0.2), soft=st.booleans())
def test_never_beyond_and_never_too_soon(
    now: float, target: float, after_s: float, soft: bool
) -> None:
    """A step stays between the old speed and the target, and never exceeds the acceleration."""
    after = ramp.towards(Twist(target, 0.0), Twist(now, 0.0), after_s, SOFT, soft=soft).linear_mps
    tolerance = 1e-12
    assert min(now, target) - tolerance <= after <= max(now, target) + tolerance
    same_way = now * after > 0
    faster_by = abs(after) - abs(now) if same_way else abs(after)
    assert faster_by <= SOFT.acceleration_mps2 * after_s + tolerance
    slower_by = abs(now) - (abs(after) if same_way else 0.0)
    if soft:
        assert slower_by <= SOFT.braking_mps2 * after_s + tolerance


@given(now=speeds, target=speeds, soft=st.booleans())
def test_arrives(now: float, target: float, soft: bool) -> None:
    """After enough steps the robot has exactly the commanded speed, and keeps it."""
    twist = Twist(now, -now)
    for _ in range(1000):
        twist = ramp.towards(Twist(target, -target), twist, 0.04, SOFT, soft=soft)
    assert twist == Twist(target, -target)
