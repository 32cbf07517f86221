"""The simulated robot without its threads."""

from __future__ import annotations

import math
from typing import Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.config.robot import RobotSettings
from wax.driver.interface import STANDSTILL, Twist
from wax.robot.simulated.flat import furnished_flat
from wax.robot.simulated.simulation import Simulation

WORLD = furnished_flat()
AHEAD = Twist(0.5, 0.0)


def started(
    now_s: float = 100.0, base: Literal["differential", "mecanum"] = "differential"
) -> Simulation:
    simulation = Simulation(RobotSettings(base=base), WORLD)
    simulation.start(now_s)
    return simulation


def speed_mps(simulation: Simulation, now_s: float) -> float:
    return simulation.advance(now_s).twist.linear_mps


def test_it_moves_and_stops() -> None:
    """A set-point moves it, and a stop brings it to rest within 200 ms."""
    simulation = started()
    for tick in range(25):
        simulation.apply(AHEAD, 1, 100.0 + tick * 0.02)
        simulation.advance(100.0 + tick * 0.02)
    assert speed_mps(simulation, 100.5) > 0.4
    simulation.stop(1)
    assert speed_mps(simulation, 100.7) == 0.0


def test_a_mecanum_base_moves_sideways() -> None:
    """Its wheels turn as fast as ahead, it gets where its speed takes it, and it stops as soon."""
    sideways, ahead = started(base="mecanum"), started(base="mecanum")
    for tick in range(25):
        sideways.apply(Twist(lateral_mps=0.5), 1, 100.0 + tick * 0.02)
        ahead.apply(AHEAD, 1, 100.0 + tick * 0.02)
        senses, straight = (one.advance(100.0 + tick * 0.02) for one in (sideways, ahead))
        assert [*map(abs, senses.wheels_mps)] == pytest.approx(straight.wheels_mps)
        assert senses.motor_c == pytest.approx(straight.motor_c)
    assert senses.twist.lateral_mps == pytest.approx(0.5)
    to_the_left = math.atan2(senses.pose.y_m - WORLD.start.y_m, senses.pose.x_m - WORLD.start.x_m)
    assert to_the_left == pytest.approx(WORLD.start.heading_rad + math.pi / 2)
    assert sideways.advance(101.2).twist == STANDSTILL


def test_its_own_watchdog_stops_it() -> None:
    """Without a new set-point it stands after 0.5 s, and the next one moves it."""
    simulation = started()
    simulation.apply(AHEAD, 1, 100.0)
    assert speed_mps(simulation, 100.29) > 0.3
    assert speed_mps(simulation, 100.5) == 0.0
    assert speed_mps(simulation, 103.0) == 0.0
    simulation.apply(AHEAD, 1, 103.0)
    assert speed_mps(simulation, 103.2) > 0.2


def test_a_lower_turn_does_nothing() -> None:
    """An earlier turn's set-points and axes have no effect, but its stop has."""
    simulation = started()
    simulation.stop(5)
    simulation.apply(AHEAD, 4, 100.0)
    simulation.set_axis("pan", 1.0, 4)
    senses = simulation.advance(100.2)
    assert (senses.twist, senses.pan_rad) == (STANDSTILL, 0.0)
    simulation.apply(AHEAD, 5, 100.2)
    simulation.advance(100.4)
    simulation.stop(1)
    assert speed_mps(simulation, 100.6) == 0.0


def test_the_head_turns_at_its_own_rate() -> None:
    """Full pan is 60 degrees to the left, reached within 0.6 s and never exceeded."""
    simulation = started()
    simulation.set_axis("pan", 7.0, 1)
    assert 0.1 < simulation.advance(100.1).pan_rad < 0.5
    assert simulation.advance(100.6).pan_rad == pytest.approx(math.radians(60.0))
    simulation.set_axis("pan", -1.0, 1)
    simulation.set_axis("no such axis", 1.0, 1)
    assert simulation.advance(101.0).pan_rad == pytest.approx(math.radians(60.0) - 0.8)


def test_a_long_sleep_is_skipped() -> None:
    """After years of sleep the robot is at once where its watchdog would have left it."""
    simulation = started()
    simulation.apply(AHEAD, 1, 100.0)
    senses = simulation.advance(1e9)
    assert senses.twist == STANDSTILL
    assert 0.05 < senses.pose.x_m - WORLD.start.x_m < 0.2
    assert senses.at_s == pytest.approx(1e9, abs=0.011)


calls = st.lists(
    st.tuples(st.floats(-1, 1), st.floats(-2, 2), st.integers(0, 3), st.floats(0.0, 0.2)),
    max_size=40,
)


@examples(25)
@given(calls)
def test_the_same_calls_give_the_same_ride(ride: list[tuple[float, float, int, float]]) -> None:
    """Two robots with the same commands at the same times are always in the same place."""
    first, second = started(), started()
    now_s = 100.0
    for linear, angular, turn, pause_s in ride:
        for simulation in (first, second):
            simulation.apply(Twist(linear, angular), turn, now_s)
        now_s += pause_s
        assert first.advance(now_s) == second.advance(now_s)
