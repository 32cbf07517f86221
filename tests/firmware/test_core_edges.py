"""The edges of the firmware's behaviour: first, last, smallest, longest."""

from __future__ import annotations

import pytest
from tests.firmware.core import Core, Verdict
from tests.firmware.core_bench import AHEAD, WRAP, Bench

from wax.robot.serial.frames import (
    NO_SESSION,
    AxisBody,
    Decoder,
    DriveBody,
    Frame,
    HelloBody,
    ReportBody,
    StopBody,
    encode,
)

# --- the start ----------------------------------------------------------------------------


def test_it_begins_without_a_turn_and_without_a_fault() -> None:
    """Before any hello it reports every 50 ms that it stands and has accepted nothing."""
    core = Core()
    for now_ms in range(51):
        core.tick(now_ms)
        data = core.report(now_ms)
        assert bool(data) is (now_ms == 50)
    [frame] = Decoder(NO_SESSION).feed(data)
    assert frame == Frame(ReportBody(0, 0, 0, 0, 0, 0), sequence=1, turn=0, ttl_ms=0, time_ms=50)


def test_a_hello_is_answered_at_once() -> None:
    """It is answered however soon after the last report it comes."""
    bench = Bench()
    bench.told()
    assert bench.report() is None
    bench.say(HelloBody(bench.session))
    frame = bench.report()
    assert frame is not None
    assert bench.report() is None
    assert (frame.turn, frame.ttl_ms) == (0, 0)


# --- turns and time -----------------------------------------------------------------------


def test_a_stop_of_a_past_turn_brings_nothing_of_it_back() -> None:
    """It stops, and the newest turn stays the newest."""
    bench = Bench()
    assert bench.say(AHEAD, turn=5) is Verdict.TAKEN
    assert bench.say(StopBody(), turn=2) is Verdict.TAKEN
    assert bench.say(AHEAD, turn=4) is Verdict.OLD_TURN
    assert bench.say(AHEAD, turn=5) is Verdict.TAKEN


def test_a_hello_of_seven_weeks_ago_is_not_of_this_moment() -> None:
    """When the clock returns to the hello's time after a wrap, the hello is old all the same."""
    bench = Bench()
    for _ in range(2):
        bench.now_ms += WRAP // 2
        bench.core.tick(bench.now_ms)
    bench.now_ms += 50
    bench.core.tick(bench.now_ms)
    assert bench.say(AHEAD, time_ms=bench.now_ms - 100) is Verdict.TAKEN


# --- the wheels ---------------------------------------------------------------------------


def test_an_axis_does_not_end_the_motion() -> None:
    """The camera turns while the robot drives."""
    bench = Bench()
    bench.say(AHEAD)
    bench.wait(10)
    before = bench.core.wheels_mmps
    assert bench.say(AxisBody(0, 5000)) is Verdict.TAKEN
    bench.wait(10)
    assert bench.core.wheels_mmps[0] > before[0] > 0


def test_motion_does_not_move_an_axis() -> None:
    """The camera keeps its direction when the robot drives and when it stops."""
    bench = Bench()
    bench.say(AxisBody(0, 5000))
    bench.say(AHEAD)
    bench.say(StopBody())
    assert bench.core.axes[0] == 5000


@pytest.mark.parametrize("sign", [1, -1])
def test_the_slowest_ramp_gets_there(sign: int) -> None:
    """At 1 mm/s² and a tick each millisecond the wheels turn at 1 mm/s after a second."""
    bench = Bench(acceleration_mmps2=1)
    for _ in range(10):
        bench.say(DriveBody(sign * 600, sign * 600), ttl_ms=1000)
        bench.wait(100)
    assert bench.core.wheels_mmps == (sign, sign)


@pytest.mark.parametrize(("wheels", "bumper"), [((1, 0), 1), ((0, 1), 1), ((-1, 0), 2)])
def test_a_bumper_stops_the_slowest_motion(wheels: tuple[int, int], bumper: int) -> None:
    """Even the slowest motion towards the obstacle is stopped."""
    bench = Bench()
    bench.say(DriveBody(*wheels))
    bench.wait(20, bumpers=bumper)
    assert bench.stands
    bench.wait(20, bumpers=3 - bumper)
    assert not bench.stands


# --- bytes --------------------------------------------------------------------------------


def test_a_frame_that_is_too_long_is_known_by_its_third_byte() -> None:
    """A payload of 32 bytes is waited for; one of 33 is damage at once."""
    for length, damaged in ((32, 0), (33, 1), (255, 1)):
        core = Core()
        core.hear(bytes([0xA5, 0x5A, length]), 0)
        assert core.damaged == damaged


@pytest.mark.parametrize("length", [238, 239, 254, 255])
def test_an_impossible_length_costs_one_frame(length: int) -> None:
    """The next frame is read, and no part of it counts as damage."""
    core = Core()
    core.push(bytes([0xA5, 0x5A, length]) + encode(Frame(HelloBody(7)), 7))
    found = core.next(0)
    assert found is not None
    assert found[0].body == HelloBody(7)
    assert core.damaged == 1


def test_it_keeps_one_frame_and_no_more() -> None:
    """Of bytes that were not asked for it keeps the first 50, the length of the longest frame."""
    hello = encode(Frame(HelloBody(7)), 7)
    for noise, is_found in ((50 - len(hello), True), (51 - len(hello), False)):
        core = Core()
        core.push(bytes(noise) + hello)
        assert (core.next(0) is not None) is is_found
