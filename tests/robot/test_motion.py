"""How the simulated robot moves."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.driver.interface import STANDSTILL, Limits, Pose, Twist
from wax.robot.simulated.flat import furnished_flat
from wax.robot.simulated.motion import ACCELERATION_MPS2, RADIUS_M, Motion, step

WORLD = furnished_flat()
LIMITS = Limits(linear_mps=0.6, angular_rps=1.5)
SIDEWAYS = Limits(linear_mps=0.6, angular_rps=1.5, lateral_mps=0.4)
DT_S = 0.01
OPEN_FLOOR = Pose(3.4, 3.4, math.pi)


def drive(motion: Motion, twist: Twist, seconds: float, limits: Limits = LIMITS) -> list[Motion]:
    path = [motion]
    for _ in range(round(seconds / DT_S)):
        path.append(step(path[-1], twist, limits, WORLD, DT_S))
    return path


def clearance_m(motion: Motion) -> float:
    return WORLD.nearest_surface(motion.pose.x_m, motion.pose.y_m)[0]


twists = st.builds(Twist, st.floats(-2, 2), st.floats(-4, 4), st.floats(-2, 2))
rides = st.lists(st.tuples(twists, st.integers(1, 120)), min_size=1, max_size=12)


@examples(60)
@given(rides, st.sampled_from((LIMITS, SIDEWAYS)))
def test_never_inside_anything_and_never_too_fast(
    ride: list[tuple[Twist, int]], limits: Limits
) -> None:
    """However it is driven, the robot touches nothing and keeps its speed limits."""
    motion = Motion(WORLD.start)
    for twist, steps in ride:
        for _ in range(steps):
            before, motion = motion, step(motion, twist, limits, WORLD, DT_S)
            way_m = math.hypot(motion.pose.x_m - before.pose.x_m, motion.pose.y_m - before.pose.y_m)
            assert clearance_m(motion) >= RADIUS_M - 1e-9
            assert way_m <= limits.linear_mps * DT_S * (1 + 1e-6)
            assert abs(motion.linear_mps) <= limits.linear_mps
            assert abs(motion.angular_rps) <= limits.angular_rps
            assert abs(motion.lateral_mps) <= limits.lateral_mps


@examples(30)
@given(st.floats(-math.pi, math.pi), st.floats(5.0, 10.0))
def test_the_fastest_robot_does_not_tunnel(heading: float, speed: float) -> None:
    """Walls hold even at 10 m/s, the most that can be configured."""
    fast = Limits(linear_mps=speed, angular_rps=1.0)
    motion = Motion(Pose(WORLD.start.x_m, WORLD.start.y_m, heading))
    for _ in range(300):
        motion = step(motion, Twist(speed, 0.3), fast, WORLD, DT_S)
        assert clearance_m(motion) >= RADIUS_M - 1e-9


def test_being_pushed_out_of_a_corner_adds_no_speed() -> None:
    """Between two surfaces the robot moves no further than its speed allows."""
    corner = Pose(6.570175, 8.301864, -2.246502)
    fast = Limits(linear_mps=10.0, angular_rps=1.0)
    after = step(Motion(corner, linear_mps=10.0), Twist(10.0, 0.0), fast, WORLD, DT_S).pose
    assert math.hypot(after.x_m - corner.x_m, after.y_m - corner.y_m) <= 10.0 * DT_S * (1 + 1e-6)


def test_the_start_is_free() -> None:
    """The robot starts with room to turn."""
    assert clearance_m(Motion(WORLD.start)) > RADIUS_M + 0.1


def test_it_drives_along_its_heading() -> None:
    """Once up to speed, it drives along its heading by speed times time."""
    path = drive(Motion(OPEN_FLOOR), Twist(0.5, 0.0), 2.0)
    late = path[-1].pose.x_m - path[-101].pose.x_m
    assert late == pytest.approx(-0.5, abs=1e-6)
    assert path[-1].pose.y_m == pytest.approx(OPEN_FLOOR.y_m)


def test_it_moves_sideways_only_on_wheels_that_can() -> None:
    """To the left of its heading, at its limit sideways, without turning; else not at all."""
    path = drive(Motion(OPEN_FLOOR), Twist(lateral_mps=1.0), 2.0, SIDEWAYS)
    last = path[-1]
    assert path[-101].pose.y_m - last.pose.y_m == pytest.approx(SIDEWAYS.lateral_mps)
    assert last.pose.x_m == pytest.approx(OPEN_FLOOR.x_m)
    assert last.pose.heading_rad == OPEN_FLOOR.heading_rad
    assert drive(Motion(OPEN_FLOOR), Twist(lateral_mps=1.0), 2.0)[-1] == Motion(OPEN_FLOOR)


def test_sideways_it_passes_a_door() -> None:
    """The door between living room and hall lets it pass, looking along the wall."""
    before_the_door = Motion(Pose(3.1, 4.0, 0.0))
    path = drive(before_the_door, Twist(lateral_mps=0.4), 4.0, SIDEWAYS)
    rooms = [WORLD.room_at(one.pose.x_m, one.pose.y_m) for one in (path[0], path[-1])]
    assert [room and room.name for room in rooms] == ["living room", "hall"]
    assert max(one.impact_mps for one in path) == 0.0


def test_sideways_it_slides_along_a_wall() -> None:
    """Ahead and into a wall at its side, it slides on, and hits the wall once."""
    start = Pose(6.3, 0.4, 0.0)
    path = drive(Motion(start), Twist(0.4, 0.0, -0.2), 1.5, SIDEWAYS)
    assert clearance_m(path[-1]) == pytest.approx(RADIUS_M, abs=1e-3)
    assert path[-1].pose.x_m > start.x_m + 0.3
    assert path[-1].pose.heading_rad == 0.0
    assert sum(one.impact_mps > 0.02 for one in path) == 1


def test_positive_is_left() -> None:
    """A positive angular speed turns counter-clockwise."""
    motion = drive(Motion(OPEN_FLOOR), Twist(0.0, 1.0), 0.5)[-1]
    assert math.remainder(motion.pose.heading_rad - OPEN_FLOOR.heading_rad, math.tau) > 0.3


def test_speed_ramps_and_brakes_harder() -> None:
    """Speed rises at the acceleration, and falls faster."""
    path = drive(Motion(OPEN_FLOOR), Twist(0.6, 0.0), 0.6)
    steps = [b.linear_mps - a.linear_mps for a, b in pairwise(path)]
    assert max(steps) == pytest.approx(ACCELERATION_MPS2 * DT_S)
    assert path[-1].linear_mps == pytest.approx(0.6)
    stopped = drive(path[-1], STANDSTILL, 0.16)[-1]
    assert stopped.linear_mps == 0.0


def test_head_on_it_stops_once_with_one_bump() -> None:
    """A wall takes all speed, in one impact at the speed of the robot."""
    path = drive(Motion(Pose(6.3, 2.9, -math.pi / 2)), Twist(0.6, 0.0), 6.0)
    impacts = [motion.impact_mps for motion in path if motion.impact_mps > 0.05]
    assert impacts == [pytest.approx(0.6, abs=0.02)]
    assert clearance_m(path[-1]) == pytest.approx(RADIUS_M, abs=1e-3)
    assert abs(path[-1].pose.y_m - path[-100].pose.y_m) < 1e-3


def test_at_an_angle_it_slides_along_the_wall() -> None:
    """At an angle, a wall leaves only the speed along it."""
    start = Pose(6.3, 0.4, math.radians(-30.0))
    path = drive(Motion(start), Twist(0.6, 0.0), 1.5)
    assert clearance_m(path[-1]) == pytest.approx(RADIUS_M, abs=1e-3)
    assert path[-1].pose.x_m > start.x_m + 0.4
    assert path[-1].linear_mps < 0.6 * math.cos(math.radians(30.0))


def test_it_can_leave_what_it_touches() -> None:
    """Backing away from a wall is free, without another bump."""
    stuck = drive(Motion(Pose(6.3, 2.9, -math.pi / 2)), Twist(0.6, 0.0), 6.0)[-1]
    back = drive(stuck, Twist(-0.4, 0.0), 1.0)
    assert back[-1].pose.y_m > stuck.pose.y_m + 0.2
    assert max(motion.impact_mps for motion in back[1:]) == 0.0


def test_every_room_can_be_reached() -> None:
    """The robot fits through the doors from the start into each room."""
    grid_m = 0.1
    seen = {(round(WORLD.start.x_m / grid_m), round(WORLD.start.y_m / grid_m))}
    frontier, reached = list(seen), set()
    while frontier:
        x, y = frontier.pop()
        for place in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)):
            if place in seen:
                continue
            seen.add(place)
            x_m, y_m = place[0] * grid_m, place[1] * grid_m
            if WORLD.nearest_surface(x_m, y_m)[0] > RADIUS_M + 0.02:
                reached.add(WORLD.room_at(x_m, y_m))
                frontier.append(place)
    assert reached == set(WORLD.rooms)
