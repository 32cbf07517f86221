"""How quickly the robot reaches the commanded speed."""

from __future__ import annotations

import math
from dataclasses import astuple, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.control.rules import RULES
from tests.control.velocity import gained, velocity

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
        now, target = (Twist(mps, 4 * mps) for mps in (now_mps, target_mps))
        after = ramp.towards(target, now, 0.1, rules, soft=True)
        assert after.linear_mps == pytest.approx(expected)
        assert after.angular_rps == pytest.approx(4 * expected)
        now, target = (Twist(lateral_mps=mps) for mps in (now_mps, target_mps))
        after = ramp.towards(target, now, 0.1, rules, soft=True)
        assert astuple(after) == pytest.approx((0.0, 0.0, expected))


@pytest.mark.parametrize(
    ("target", "expected", "expected_soft"),
    [
        (Twist(0.0, 0.0, 0.6), Twist(0.0, 0.0, 0.1), Twist(0.6, 0.0, 0.0)),
        (Twist(0.0, 0.0, -0.6), Twist(0.0, 0.0, -0.1), Twist(0.6, 0.0, 0.0)),
        (Twist(0.7, 0.0, 0.6), Twist(0.7, 0.0, 0.1), Twist(0.7, 0.0, 0.05)),
        (Twist(0.7, 0.0, -0.05), Twist(0.7, 0.0, -0.05), Twist(0.7, 0.0, -0.05)),
        (Twist(-0.3, 0.0, 0.4), Twist(-0.06, 0.0, 0.08), Twist(0.6, 0.0, 0.0)),
        (Twist(1.1, 0.0, 0.4), Twist(0.86, 0.0, 0.08), Twist(0.86, 0.0, 0.08)),
    ],
)
def test_into_another_direction(target: Twist, expected: Twist, expected_soft: Twist) -> None:
    """It keeps what of its speed points there, and gains the rest in a straight line."""
    for rules, after in ((RULES, expected), (SOFT, expected_soft)):
        told = ramp.towards(target, Twist(0.8), 0.1, rules, soft=True)
        assert astuple(told) == pytest.approx(astuple(after))


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
vectors = st.builds(complex, speeds, st.one_of(st.just(0.0), speeds))


def twist(speed: complex) -> Twist:
    """Return a twist that moves so, and turns as fast as it goes ahead."""
    return Twist(speed.real, speed.real, speed.imag)


@given(now=vectors, target=vectors, after_s=st.floats(0, 0.2), soft=st.booleans())
def test_never_beyond_and_never_too_soon(
    now: complex, target: complex, after_s: float, soft: bool
) -> None:
    """A step is no faster than before or than asked, and keeps to the two rates in any direction.

    Along one axis it stays between the old speed and the target.
    """
    after = velocity(ramp.towards(twist(target), twist(now), after_s, SOFT, soft=soft))
    tolerance = 1e-9
    assert abs(after) <= max(abs(now), abs(target)) + tolerance
    assert gained(now, after) <= SOFT.acceleration_mps2 * after_s + tolerance
    kept = (after * now.conjugate()).real / abs(now) if abs(now) > tolerance else 0.0
    if soft:
        assert abs(now) - max(0.0, kept) <= SOFT.braking_mps2 * after_s + tolerance
    if now.imag == target.imag == 0.0:
        assert min(now.real, target.real) <= after.real <= max(now.real, target.real)
        assert after.imag == 0.0


def on_one_axis(target: float, now: float, after_s: float, *, slower: float) -> float:
    """Return what the ramp of a robot with one axis makes of a speed."""
    way = math.copysign(1.0, now)
    kept = max(0.0, min(abs(now), target * way))
    slowing_s = (abs(now) - kept) / slower
    if slowing_s > after_s:
        return way * max(kept, abs(now) - slower * after_s)
    gained = SOFT.acceleration_mps2 * (after_s - slowing_s)
    rest = target * way - kept
    return target if abs(rest) <= gained else way * (kept + math.copysign(gained, rest))


@given(now=speeds, target=speeds, after_s=st.floats(0, 0.2), soft=st.booleans())
def test_without_sideways_it_is_a_ramp_of_one_axis(
    now: float, target: float, after_s: float, soft: bool
) -> None:
    """A base that cannot move sideways gets the very numbers of a ramp that knows one axis."""
    after = ramp.towards(Twist(target), Twist(now), after_s, SOFT, soft=soft)
    slower = SOFT.braking_mps2 if soft else math.inf
    assert after == Twist(on_one_axis(target, now, after_s, slower=slower))


@given(target=vectors, gaps_s=st.lists(st.floats(1e-3, 0.2), min_size=1, max_size=20))
def test_from_standstill_the_direction_is_right_at_once(
    target: complex, gaps_s: list[float]
) -> None:
    """However it is ramped up, the robot moves in the direction asked for from the first step."""
    now = STANDSTILL
    for gap_s in gaps_s:
        now = ramp.towards(twist(target), now, gap_s, RULES, soft=True)
        aside = (velocity(now) * target.conjugate()).imag
        assert abs(aside) <= 1e-9 * abs(target)
    assert abs(velocity(now)) == pytest.approx(min(abs(target), sum(gaps_s)))


@given(now=vectors, target=vectors, soft=st.booleans())
def test_arrives(now: complex, target: complex, soft: bool) -> None:
    """After enough steps the robot has exactly the commanded speed, and keeps it."""
    told = twist(now)
    for _ in range(1000):
        told = ramp.towards(twist(target), told, 0.04, SOFT, soft=soft)
    assert told == twist(target)
