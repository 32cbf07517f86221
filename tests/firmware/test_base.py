"""Four mecanum wheels or three omni wheels: what each turns for a motion, and what stops it."""

from __future__ import annotations

import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from tests.firmware.core import Kind, Verdict
from tests.firmware.core_bench import AHEAD, SESSION, Bench

from wax.robot.serial.frames import DriveBody, HelloBody, MoveBody, StopBody

HASTE = {"acceleration_mmps2": 65_535, "braking_mmps2": 65_535}
ARM_MM = 200
SIDEWAYS = MoveBody(0, 300, 0)

both = pytest.mark.parametrize("kind", [Kind.MECANUM, Kind.OMNI])
int16 = st.integers(-(2**15), 2**15 - 1)


def of(kind: Kind, **settings: int) -> Bench:
    return Bench(**HASTE | {"kind": kind, "arm_mm": ARM_MM} | settings)


def wheels(kind: Kind, body: MoveBody | DriveBody, **settings: int) -> tuple[int, ...]:
    """Return the wheels' speeds once they are reached."""
    bench = of(kind, **settings)
    assert bench.say(body, ttl_ms=1000) is Verdict.TAKEN
    bench.wait(999)
    return bench.core.wheels_mmps


@pytest.mark.parametrize(
    ("body", "mecanum", "omni"),
    [
        (MoveBody(500, 0, 0), (500, 500, 500, 500), (433, 433, 0)),
        (MoveBody(-500, 0, 0), (-500, -500, -500, -500), (-433, -433, 0)),
        (MoveBody(0, 500, 0), (-500, 500, 500, -500), (-250, 250, 500)),
        (MoveBody(0, -500, 0), (500, -500, -500, 500), (250, -250, -500)),
        (MoveBody(0, 0, 1000), (-200, 200, -200, 200), (-200, 200, -200)),
        (MoveBody(424, 424, 0), (0, 848, 848, 0), (155, 579, 424)),
        (MoveBody(300, -100, -500), (500, 100, 300, 300), (409, 109, 0)),
    ],
)
def test_each_wheel_turns_for_its_place(
    body: MoveBody, mecanum: tuple[int, ...], omni: tuple[int, ...]
) -> None:
    """Ahead, to the left and turning left are sums over what each wheel's rollers allow."""
    assert wheels(Kind.MECANUM, body) == mecanum
    assert wheels(Kind.OMNI, body) == omni


@both
def test_an_old_servers_drive_moves_it_as_two_sides(kind: Kind) -> None:
    """Two speeds of sides are a motion without a part sideways, round the same radius."""
    assert wheels(kind, DriveBody(300, 500)) == wheels(kind, MoveBody(400, 0, 500))
    assert wheels(kind, DriveBody(0, 0)) == (0,) * kind.wheels


@both
@given(st.builds(MoveBody, int16, int16, int16), st.integers(1, 32_767), st.integers(0, 65_535))
@example(MoveBody(32_767, 32_767, 32_767), 32_767, 65_535)
@example(MoveBody(513, 0, 36), 440, 66)
def test_what_is_too_fast_is_slowed_as_a_whole(
    kind: Kind, body: MoveBody, fastest: int, arm_mm: int
) -> None:
    """No wheel is faster than the fastest, and the wheels keep their proportions."""
    bench = of(kind, fastest_mmps=fastest, arm_mm=arm_mm)
    bench.say(body, ttl_ms=1000)
    bench.wait(600)
    found = bench.core.wheels_mmps
    linear, lateral = body.linear_mmps, body.lateral_mmps
    spin = body.angular_mradps * arm_mm / 1000
    if kind is Kind.MECANUM:
        wanted: tuple[float, ...] = (
            linear - lateral - spin,
            linear + lateral + spin,
            linear + lateral - spin,
            linear - lateral + spin,
        )
    else:
        ahead = linear * 0.866
        wanted = (ahead - lateral / 2 - spin, ahead + lateral / 2 + spin, lateral - spin)
    excess = max(1.0, *(abs(speed) / fastest for speed in wanted))
    assert max(map(abs, found)) <= fastest
    for speed, asked in zip(found, wanted, strict=True):
        assert abs(speed - asked / excess) <= 2 + fastest / 8192


def test_two_sides_are_as_fast_as_they_are_told() -> None:
    """The server has mixed and limited them; no wheel of theirs is slowed for the other."""
    assert wheels(Kind.SIDES, DriveBody(900, -450), fastest_mmps=500) == (900, -450)


def test_a_board_with_two_sides_refuses_a_move() -> None:
    """It says in its reports that it cannot, counts the frame as refused, and stands."""
    bench = Bench()
    assert not bench.told().moves_sideways
    assert bench.say(SIDEWAYS) is Verdict.CANNOT
    assert bench.say(MoveBody(100, 0, 0)) is Verdict.CANNOT
    bench.wait(50)
    assert bench.stands
    assert bench.told().refused == 2
    assert bench.say(AHEAD, sequence=2) is Verdict.TAKEN


@both
def test_it_says_that_it_can(kind: Kind) -> None:
    """Its reports say so from the first on, also before any hello."""
    bench = of(kind)
    assert bench.told().moves_sideways
    assert bench.told().flags == 4


@both
def test_the_past_is_refused_sideways_as_ahead(kind: Kind) -> None:
    """Turn, sequence and age count for a move as for a drive."""
    bench = of(kind)
    bench.wait(1000)
    assert bench.say(SIDEWAYS, turn=5) is Verdict.TAKEN
    assert bench.say(SIDEWAYS, turn=4) is Verdict.OLD_TURN
    assert bench.say(SIDEWAYS, turn=5, sequence=2) is Verdict.OLD_SEQUENCE
    bench.sequence += 9
    assert bench.say(SIDEWAYS, turn=5, time_ms=bench.now_ms - 201) is Verdict.LATE
    assert bench.say(SIDEWAYS, turn=5, time_ms=bench.now_ms + 51) is Verdict.LATE
    assert bench.say(SIDEWAYS, turn=5, session=SESSION + 1) is None


@both
def test_its_watchdog_stops_every_wheel(kind: Kind) -> None:
    """To the millisecond, and nothing moves it until a stop or a hello."""
    for again in (StopBody(), HelloBody(SESSION)):
        bench = of(kind)
        bench.say(SIDEWAYS, ttl_ms=200)
        bench.wait(199)
        assert bench.core.wheels_mmps[1] > 0
        bench.wait(1 + 10)
        assert bench.stands
        assert bench.core.timed_out
        assert bench.say(SIDEWAYS) is Verdict.TIMED_OUT
        bench.say(again)
        assert bench.say(SIDEWAYS) is Verdict.TAKEN


@both
@pytest.mark.parametrize("end", [StopBody(), HelloBody(SESSION)])
def test_a_stop_ends_motion_sideways(kind: Kind, end: StopBody | HelloBody) -> None:
    """All wheels brake at the configured rate."""
    bench = of(kind, braking_mmps2=20_000)
    bench.say(SIDEWAYS, ttl_ms=1000)
    bench.wait(100)
    bench.say(end)
    bench.wait(14)
    assert not bench.stands
    bench.wait(2)
    assert bench.stands


def test_each_wheel_keeps_to_its_ramp() -> None:
    """A wheel gains at most the configured speed in each step, at the back as in front."""
    bench = of(Kind.MECANUM, acceleration_mmps2=1000)
    bench.say(SIDEWAYS, ttl_ms=1000)
    for now in range(1, 301):
        bench.wait(1)
        assert bench.core.wheels_mmps == (-now, now, now, -now)
    assert bench.core.moving


def test_one_back_wheel_is_motion_too() -> None:
    """While only a back wheel still turns, the robot reports motion."""
    bench = of(Kind.OMNI)
    bench.say(MoveBody(0, 2, 5))
    bench.wait(1)
    assert bench.core.wheels_mmps == (-2, 2, 1)
    bench.say(MoveBody(0, 1, 0))
    bench.wait(1)
    assert bench.core.wheels_mmps == (0, 0, 1)
    assert bench.core.moving


@both
def test_a_pressed_bumper_stops_the_way_there_sideways(kind: Kind) -> None:
    """Front 1, back 2, left 4 and right 8 each end motion with a part to their side."""
    blocked = {
        MoveBody(0, 100, 0): 4,
        MoveBody(0, -100, 0): 8,
        MoveBody(100, 1, 0): 1 + 4,
        MoveBody(-1, -100, 0): 2 + 8,
        MoveBody(100, 0, 100): 1,
        MoveBody(0, 0, 500): 0,
    }
    for body, mask in blocked.items():
        for bumper in (1, 2, 4, 8, 16):
            bench = of(kind)
            bench.say(body, ttl_ms=1000)
            bench.wait(50)
            assert not bench.stands
            bench.wait(50, bumpers=bumper)
            assert bench.stands == bool(bumper & mask), (body, bumper)


@both
@pytest.mark.parametrize(
    ("there", "bumper", "away"),
    [(MoveBody(0, 100, 0), 4, MoveBody(0, -100, 0)), (MoveBody(100, 0, 0), 1, MoveBody(0, 0, 500))],
)
def test_a_robot_leaves_what_it_has_touched(
    kind: Kind, there: MoveBody, bumper: int, away: MoveBody
) -> None:
    """A bumper that is still pressed blocks only the way that is asked for now."""
    bench = of(kind)
    bench.say(there, ttl_ms=1000)
    bench.wait(50, bumpers=bumper)
    assert bench.stands
    bench.say(away, ttl_ms=1000)
    bench.wait(50, bumpers=bumper)
    assert not bench.stands


# --- the way to another motion --------------------------------------------------------------

SOFT = {"acceleration_mmps2": 2500, "braking_mmps2": 1000}


def motion(kind: Kind, wheels_mmps: tuple[int, ...]) -> tuple[float, float, float]:
    """Return the mm/s ahead, to the left, and of a wheel for turning left."""
    if kind is Kind.MECANUM:
        a, b, c, d = wheels_mmps
        return (a + b + c + d) / 4, (b + c - a - d) / 4, (b + d - a - c) / 4
    left, right, back = wheels_mmps
    return (left + right) / math.sqrt(3), (right - left + 2 * back) / 3, (right - left - back) / 3


def moving(kind: Kind, body: MoveBody) -> Bench:
    """Return a robot at that motion, which brakes softly."""
    bench = of(kind, **SOFT)
    bench.say(body, ttl_ms=1000)
    bench.wait(900)
    return bench


@both
@pytest.mark.parametrize(
    "body",
    [MoveBody(600, 0, 0), MoveBody(0, -600, 0), MoveBody(424, 424, 0), MoveBody(520, -300, 0)],
)
def test_the_robot_brakes_as_configured_in_each_direction(kind: Kind, body: MoveBody) -> None:
    """0.6 m/s end after 0.6 s at 1 m/s², straight, and without a turn of a degree."""
    bench = moving(kind, body)
    bench.say(StopBody())
    turned_mm = 0.0
    for passed_ms in range(1, 599):
        bench.wait(1)
        ahead, left, turn = motion(kind, bench.core.wheels_mmps)
        turned_mm += turn / 1000
        assert math.hypot(ahead, left) == pytest.approx(600 - passed_ms, abs=3)
        across = ahead * body.lateral_mmps - left * body.linear_mmps
        assert abs(across) / 600 <= 2
    bench.wait(3)
    assert bench.stands
    assert not bench.core.moving
    assert abs(turned_mm) / ARM_MM < math.radians(1)


@both
@pytest.mark.parametrize(
    "then", [MoveBody(0, 600, 0), MoveBody(-424, -424, 0), MoveBody(-600, 0, 0)]
)
def test_another_direction_is_no_turn(kind: Kind, then: MoveBody) -> None:
    """It brakes what it must at the braking rate, then accelerates, and never turns."""
    bench = moving(kind, MoveBody(600, 0, 0))
    bench.say(then, ttl_ms=1000)
    turned_mm = 0.0
    for passed_ms in range(1, 841):
        bench.wait(1)
        ahead, left, turn = motion(kind, bench.core.wheels_mmps)
        turned_mm += turn / 1000
        gained = max(0.0, 2.5 * (passed_ms - 600))
        speed = max(600.0 - passed_ms, min(600.0, gained))
        assert math.hypot(ahead, left) == pytest.approx(speed, abs=4)
    assert motion(kind, bench.core.wheels_mmps)[:2] == pytest.approx(
        (then.linear_mmps, then.lateral_mmps), abs=1
    )
    assert abs(turned_mm) / ARM_MM < math.radians(1)


@both
def test_a_turn_has_a_ramp_of_its_own(kind: Kind) -> None:
    """A turn neither delays the end of the motion ahead nor ends later than its own rate says."""
    bench = moving(kind, MoveBody(200, 0, 2000))
    bench.say(StopBody())
    bench.wait(201)
    ahead, left, turn = motion(kind, bench.core.wheels_mmps)
    assert (ahead, left) == pytest.approx((0, 0), abs=1)
    assert turn == pytest.approx(199, abs=1)
    bench.wait(199)
    assert bench.stands


@both
def test_the_slowest_ramp_keeps_its_direction_too(kind: Kind) -> None:
    """At 1 mm/s² both parts of a diagonal grow, and end where they should."""
    bench = of(kind, acceleration_mmps2=1)
    for _ in range(7):
        bench.say(MoveBody(3, 3, 0), ttl_ms=1000)
        bench.wait(900)
    assert bench.core.wheels_mmps == wheels(kind, MoveBody(3, 3, 0))


@pytest.mark.parametrize("step_ms", [1, 5])
def test_a_slow_ramp_is_rounded_to_the_nearest(step_ms: int) -> None:
    """Each step adds what is due to each part, at most half a micrometre a second off."""
    bench = of(Kind.MECANUM, acceleration_mmps2=10, fastest_mmps=32_767)
    start_ms = bench.now_ms
    for _ in range(9):
        bench.say(MoveBody(9640, 2650, 0), ttl_ms=1000)
        for _ in range(999 // step_ms):
            bench.now_ms += step_ms
            bench.core.tick(bench.now_ms)
    passed_ms = bench.now_ms - start_ms
    ahead, left, _ = motion(Kind.MECANUM, bench.core.wheels_mmps)
    least_mmps = 1 + passed_ms / step_ms * 0.5 / 1000
    assert ahead == pytest.approx(passed_ms * 0.00964, abs=least_mmps)
    assert left == pytest.approx(passed_ms * 0.00265, abs=least_mmps)


@both
def test_what_is_left_of_a_step_is_used(kind: Kind) -> None:
    """A step that needs only a part of its time to brake accelerates in the rest."""
    bench = of(kind)
    bench.say(MoveBody(50, 0, 0))
    bench.wait(1)
    bench.say(MoveBody(0, 50, 0))
    bench.wait(1)
    assert bench.core.wheels_mmps == wheels(kind, MoveBody(0, 50, 0))
