"""From a twist to the speeds of two wheels."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.config.robot import RobotSettings
from wax.driver.interface import Twist
from wax.robot.wheels import MAX_WHEEL_MPS, WheelMixer, WheelSpeeds


def mixed(twist: Twist, **settings: object) -> WheelSpeeds:
    return WheelMixer(RobotSettings.model_validate(settings)).mix(twist)


def both(wheels: WheelSpeeds) -> tuple[float, float]:
    return wheels.left_mps, wheels.right_mps


def test_straight_and_on_the_spot() -> None:
    """Ahead both wheels are alike; turning left on the spot drives the right one ahead."""
    assert both(mixed(Twist(0.4, 0.0))) == pytest.approx((0.4, 0.4))
    assert both(mixed(Twist(0.0, 1.0), wheel_base_m=0.5)) == pytest.approx((-0.25, 0.25))
    assert both(mixed(Twist(0.2, -0.5))) == pytest.approx((0.275, 0.125))


def test_trim_and_inversion_belong_to_one_wheel() -> None:
    """Trim slows its own wheel in both directions, and inversion reverses its own."""
    assert both(mixed(Twist(0.4, 0.0), left_trim=0.9)) == pytest.approx((0.36, 0.4))
    assert both(mixed(Twist(-0.4, 0.0), right_trim=0.5)) == pytest.approx((-0.4, -0.2))
    assert both(mixed(Twist(0.4, 0.0), invert_right=True)) == pytest.approx((0.4, -0.4))
    back = mixed(Twist(-0.4, 0.0), invert_left=True, left_trim=0.5)
    assert both(back) == pytest.approx((0.2, -0.4))


@given(
    st.floats(-20, 20),
    st.floats(-40, 40),
    st.floats(0.1, 10),
    st.floats(0.1, 20),
    st.floats(0.05, 5),
)
def test_no_wheel_is_too_fast_and_every_curve_keeps_its_radius(
    linear: float, angular: float, max_linear: float, max_angular: float, base_m: float
) -> None:
    """Both wheels stay within their limit, and keep the commanded ratio."""
    settings = RobotSettings(
        max_linear_mps=max_linear, max_angular_rps=max_angular, wheel_base_m=base_m
    )
    left, right = both(WheelMixer(settings).mix(Twist(linear, angular)))
    most = min(MAX_WHEEL_MPS, max(max_linear, max_angular * base_m / 2))
    assert max(abs(left), abs(right)) <= most * (1 + 1e-9)
    wanted_left, wanted_right = linear - angular * base_m / 2, linear + angular * base_m / 2
    assert left * wanted_right == pytest.approx(right * wanted_left, abs=1e-6)
    assert left * wanted_left >= -1e-9


def test_no_wheel_is_faster_than_a_frame_can_carry() -> None:
    """Whatever the limits, a wheel's speed in mm/s fits into 16 bits."""
    limits = {"max_linear_mps": 1.0, "max_angular_rps": 20.0, "wheel_base_m": 5.0}
    assert both(mixed(Twist(0.0, 20.0), **limits)) == pytest.approx((-32.767, 32.767))


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_nan_and_infinity_are_standstill(bad: float) -> None:
    """Neither reaches a wheel."""
    assert mixed(Twist(bad, 0.3)) == mixed(Twist(0.3, bad)) == WheelSpeeds(0.0, 0.0)
