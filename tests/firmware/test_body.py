"""What the firmware makes of speeds, positions and voltages: power and pulses."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.firmware.core import AXES, battery, power
from tests.firmware.core_bench import Bench

from wax.robot.serial.frames import AxisBody, HelloBody, StopBody

# --- servos -------------------------------------------------------------------------------


def test_no_servo_moves_when_power_comes() -> None:
    """Without a position no axis has a pulse, whatever else is sent; then only that axis has."""
    bench = Bench()
    bench.say(HelloBody(bench.session))
    bench.say(StopBody())
    bench.wait(100)
    assert bench.core.servos_us == [0] * AXES
    bench.say(AxisBody(2, 0))
    bench.wait(1)
    assert bench.core.servos_us == [0, 0, 1500, 0]
    bench.say(AxisBody(AXES, 0))
    bench.wait(1)
    assert bench.core.servos_us == [0, 0, 1500, 0]


@pytest.mark.parametrize(
    ("position", "pulse_us"),
    [(-10_000, 1000), (-9999, 1000), (0, 1500), (5000, 1750), (10_000, 2000), (32_767, 2000)],
)
def test_a_position_is_a_pulse(position: int, pulse_us: int) -> None:
    """It goes from one end of the range to the other, in proportion, and never beyond."""
    bench = Bench()
    bench.say(AxisBody(1, position))
    bench.wait(1)
    assert bench.core.servos_us[1] == pulse_us


def test_a_servo_may_be_turned_round() -> None:
    """With the larger pulse first, 1 is where -1 was."""
    bench = Bench(least_us=2500, most_us=500)
    for position, pulse_us in ((-10_000, 2500), (-5000, 2000), (10_000, 500)):
        bench.say(AxisBody(0, position))
        bench.wait(2000)
        bench.say(AxisBody(0, position))
        assert bench.core.servos_us[0] == pulse_us


def test_a_servo_is_not_thrown() -> None:
    """The first position is reached at once; then it moves at its limited speed, both ways."""
    bench = Bench(us_per_s=2000)
    bench.say(AxisBody(0, 10_000))
    bench.wait(1)
    assert bench.core.servos_us[0] == 2000
    for position, step_us, ends_us in ((-10_000, -2, 1000), (10_000, 2, 2000)):
        before = bench.core.servos_us[0]
        bench.say(AxisBody(0, position))
        for number in range(1, 500):
            bench.wait(1)
            assert bench.core.servos_us[0] == before + number * step_us
        bench.wait(2)
        assert bench.core.servos_us[0] == ends_us


def test_a_pause_does_not_throw_a_servo() -> None:
    """A second in which nothing ran counts for 20 ms."""
    bench = Bench(us_per_s=1000)
    bench.say(AxisBody(0, 0))
    bench.wait(1)
    bench.say(AxisBody(0, 10_000))
    bench.now_ms += 1000
    bench.core.tick(bench.now_ms)
    assert bench.core.servos_us[0] == 1520


def test_an_axis_stays_when_the_robot_stops_itself() -> None:
    """A camera that suddenly looks elsewhere would help nobody."""
    bench = Bench()
    bench.say(AxisBody(0, 10_000))
    bench.wait(2000)
    bench.say(StopBody())
    bench.say(HelloBody(7))
    bench.wait(100)
    assert bench.core.servos_us[0] == 2000


def test_a_restarted_board_gives_no_pulse() -> None:
    """The board has forgotten where the axis was."""
    bench = Bench()
    bench.say(AxisBody(0, 10_000))
    bench.wait(1)
    bench.core.reset(bench.now_ms)
    bench.core.tick(bench.now_ms + 5)
    assert bench.core.servos_us == [0] * AXES


@given(
    st.integers(500, 2500),
    st.integers(500, 2500),
    st.integers(1, 65_535),
    st.lists(st.tuples(st.integers(-32_768, 32_767), st.integers(0, 40)), max_size=6),
)
def test_a_pulse_is_always_within_its_range(
    least_us: int, most_us: int, us_per_s: int, told: list[tuple[int, int]]
) -> None:
    """It never moves faster than allowed, whatever is sent, and whenever."""
    bench = Bench(least_us=least_us, most_us=most_us, us_per_s=us_per_s)
    for position, pause_ms in told:
        bench.say(AxisBody(0, position))
        for _ in range(pause_ms):
            before = bench.core.servos_us[0]
            bench.wait(1)
            now = bench.core.servos_us[0]
            assert min(least_us, most_us) <= now <= max(least_us, most_us)
            assert before == 0 or abs(now - before) <= us_per_s / 1000 + 1


# --- motors -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("mmps", "wanted"),
    [
        (0, 0), (1, 40), (-1, -40), (400, 147), (-400, -147), (799, 254), (800, 255), (-800, -255),
        (32_767, 255), (-32_768, -255),
    ],
)  # fmt: skip
def test_a_speed_is_power(mmps: int, wanted: int) -> None:
    """The slowest motion gets just enough power to turn the wheel, full speed all; 0 brakes."""
    assert power(mmps, full_mmps=800, least=40) == wanted


@given(st.integers(-32_768, 32_767), st.integers(1, 32_767), st.integers(0, 255))
def test_power_has_the_sign_of_the_speed(mmps: int, full_mmps: int, least: int) -> None:
    """Forward and back are alike, never above full power or below what turns the wheel."""
    found = power(mmps, full_mmps, least)
    assert found == -power(-mmps, full_mmps, least) or mmps == -32_768
    assert (mmps != 0) * least <= abs(found) <= 255
    assert found * mmps >= 0


# --- the battery --------------------------------------------------------------------------


def test_the_first_voltage_counts_at_once() -> None:
    """A board that has just started must not report an empty battery."""
    assert battery([512], 1023, 15_000) == [7507]
    assert battery([0], 1023, 15_000) == [0]


def test_a_dip_of_the_motors_is_smoothed() -> None:
    """An eighth of a change counts each time, so that after some readings all of it does."""
    found = battery([1000, 600] + [1000] * 60, 1000, 10_000)
    assert found[:3] == [10_000, 9500, 9560]
    assert found[-1] == 10_000
    lasting = battery([1000] + [600] * 60, 1000, 10_000)
    assert lasting[-1] == 6000


@given(st.integers(0, 4095))
def test_a_steady_voltage_is_told_as_it_is(number: int) -> None:
    """At full scale it reports full scale; no number overflows or is lost by rounding."""
    assert battery([4095] + [number] * 100, 4095, 65_535)[-1] == number * 65_535 // 4095
    assert battery([0] + [number] * 100, 4095, 65_535)[-1] == number * 65_535 // 4095
