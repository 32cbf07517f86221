"""From a twist to the speeds of the wheels, and back."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.config.bases import WHEELS_OF
from wax.config.robot import RobotSettings
from wax.driver.interface import Pose, Twist
from wax.robot.wheels import MAX_WHEEL_MPS, WheelGeometry, WheelMixer

if TYPE_CHECKING:
    from wax.config.bases import Base

BASES = st.sampled_from(list(WHEELS_OF))
SHARES = st.floats(-1, 1)


def mixed(twist: Twist, **settings: object) -> dict[str, float]:
    return WheelMixer(RobotSettings.model_validate(settings)).mix(twist)


def both(wheels: dict[str, float]) -> tuple[float, ...]:
    assert list(wheels) == ["left", "right"]
    return tuple(wheels.values())


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
    standstill = {"left": 0.0, "right": 0.0}
    assert mixed(Twist(bad, 0.3)) == mixed(Twist(0.3, bad)) == standstill
    sideways = mixed(Twist(0.3, 0.3, bad), base="omni")
    assert sideways == {"left": 0.0, "right": 0.0, "back": 0.0}


# --- bases that move sideways -------------------------------------------------------------


@pytest.mark.parametrize(
    ("twist", "wheels"),
    [
        (Twist(0.3, 0.0), (0.3, 0.3, 0.3, 0.3)),
        (Twist(0.0, 0.0, 0.3), (-0.3, 0.3, 0.3, -0.3)),
        (Twist(0.0, 1.0), (-0.5, 0.5, -0.5, 0.5)),
        (Twist(0.2, 0.0, 0.2), (0.0, 0.4, 0.4, 0.0)),
    ],
)
def test_four_mecanum_wheels(twist: Twist, wheels: tuple[float, ...]) -> None:
    """To the left, front right and back left roll ahead; on a diagonal to the left only they do."""
    found = mixed(twist, base="mecanum", wheel_base_m=0.4, axle_base_m=0.6)
    assert list(found) == ["front_left", "front_right", "back_left", "back_right"]
    assert tuple(found.values()) == pytest.approx(wheels)


@pytest.mark.parametrize(
    ("twist", "wheels"),
    [
        (Twist(0.4, 0.0), (0.346, 0.346, 0.0)),
        (Twist(0.0, 0.0, 0.4), (-0.2, 0.2, 0.4)),
        (Twist(0.0, 1.0), (-0.2, 0.2, -0.2)),
    ],
)
def test_three_omni_wheels(twist: Twist, wheels: tuple[float, ...]) -> None:
    """Ahead the back wheel stands; turning left it drives its end to the right."""
    found = mixed(twist, base="omni", omni_radius_m=0.2)
    assert list(found) == ["left", "right", "back"]
    assert tuple(found.values()) == pytest.approx(wheels, abs=0.001)


@pytest.mark.parametrize("base", ["mecanum", "omni"])
def test_a_diagonal_has_full_speed(base: str) -> None:
    """At full speed in any direction no wheel needs slowing down, so that all are as fast."""
    robot = RobotSettings.model_validate({"base": base, "max_linear_mps": 0.6})
    mixer, geometry = WheelMixer(robot), WheelGeometry(robot)
    for angle in range(0, 360, 15):
        ahead, left = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        told = geometry.motion(list(mixer.mix(Twist(ahead * 0.6, 0.0, left * 0.6)).values()))
        assert told.speed_mps == pytest.approx(0.6)


@given(BASES, st.builds(Twist, SHARES, SHARES, SHARES), st.floats(0.05, 5), st.floats(0.05, 5))
def test_the_wheels_speeds_give_the_twist_back(
    base: Base, twist: Twist, length_m: float, width_m: float
) -> None:
    """From the wheels of any base its own motion is found again."""
    sizes = {"wheel_base_m": width_m, "axle_base_m": length_m, "omni_radius_m": length_m}
    geometry = WheelGeometry(RobotSettings.model_validate({"base": base, **sizes}))
    back = geometry.motion([*geometry.speeds_mps(twist).values()])
    assert back.linear_mps == pytest.approx(twist.linear_mps, abs=1e-9)
    assert back.angular_rps == pytest.approx(twist.angular_rps, abs=1e-9)
    left_mps = twist.lateral_mps if geometry.moves_sideways else 0.0
    assert back.lateral_mps == pytest.approx(left_mps, abs=1e-9)


@given(st.sampled_from(["mecanum", "omni"]), st.floats(-9, 9), st.floats(-9, 9), st.floats(-9, 9))
def test_a_wheel_that_would_be_too_fast_slows_all_alike(
    base: str, ahead: float, turn: float, left: float
) -> None:
    """Whatever is asked for, no wheel is too fast, and direction and curve are as asked for."""
    robot = RobotSettings.model_validate({"base": base, "max_lateral_mps": 0.3})
    mixer, geometry = WheelMixer(robot), WheelGeometry(robot)
    wheels = list(mixer.mix(Twist(ahead, turn, left)).values())
    assert max(map(abs, wheels)) <= mixer.fastest_mps * (1 + 1e-9)
    told = geometry.motion(wheels)
    for one, asked in (
        (told.linear_mps * turn, told.angular_rps * ahead),
        (told.linear_mps * left, told.lateral_mps * ahead),
    ):
        assert one == pytest.approx(asked, abs=1e-6)
    assert told.linear_mps * ahead >= -1e-9
    assert told.lateral_mps * left >= -1e-9


def test_trim_and_inversion_belong_to_a_side() -> None:
    """They apply to both wheels of a side; the back one of an omni base has neither."""
    side = {"left_trim": 0.5, "invert_left": True}
    mecanum = mixed(Twist(0.4, 0.0), base="mecanum", **side)
    assert tuple(mecanum.values()) == pytest.approx((-0.2, 0.4, -0.2, 0.4))
    omni = mixed(Twist(0.0, 0.0, 0.4), base="omni", **side)
    assert tuple(omni.values()) == pytest.approx((0.1, 0.2, 0.4))


@pytest.mark.parametrize("base", ["mecanum", "omni"])
@pytest.mark.parametrize("start_rad", [1.0, 3.0])
def test_a_pose_follows_the_wheels_along_the_arc(base: Base, start_rad: float) -> None:
    """Ahead, sideways and turning at once it goes where many small steps would lead."""
    geometry = WheelGeometry(RobotSettings(base=base))
    rolled_m = [*geometry.speeds_mps(Twist(0.3, 0.4, -0.2)).values()]
    pose = geometry.moved(Pose(1.0, 2.0, start_rad), rolled_m)
    x_m, y_m, heading_rad = 1.0, 2.0, start_rad
    for _ in range(1000):
        x_m += 0.0003 * math.cos(heading_rad) + 0.0002 * math.sin(heading_rad)
        y_m += 0.0003 * math.sin(heading_rad) - 0.0002 * math.cos(heading_rad)
        heading_rad += 0.0004
    assert (pose.x_m, pose.y_m) == pytest.approx((x_m, y_m), abs=0.004)
    assert pose.heading_rad == pytest.approx(math.remainder(heading_rad, math.tau))


@pytest.mark.parametrize("base", list(WHEELS_OF))
def test_a_base_has_the_wheels_of_the_configuration(base: Base) -> None:
    """Lines of text and pins name the wheels as the geometry does; one side may be inverted."""
    geometry = WheelGeometry(RobotSettings(base=base, invert_left=True))
    assert geometry.names == WHEELS_OF[base]
    assert geometry.signs == {one: -1.0 if "left" in one else 1.0 for one in WHEELS_OF[base]}
    assert geometry.moves_sideways == (base != "differential")


def test_a_base_of_the_configuration_may_be_driven_by_its_sides() -> None:
    """For a board that is told two speeds, a base of any wheels has two sides."""
    mixer = WheelMixer(RobotSettings(base="mecanum"), "differential")
    assert both(mixer.mix(Twist(0.3, 0.0))) == (0.3, 0.3)


def test_a_slow_limit_sideways_does_not_slow_it_ahead() -> None:
    """The fastest wheel counts, not the one that turns least."""
    omni = mixed(Twist(0.6, 0.0), base="omni", max_lateral_mps=0.1, max_angular_rps=0.1)
    assert tuple(omni.values()) == pytest.approx((0.52, 0.52, 0.0), abs=0.001)
