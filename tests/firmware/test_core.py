"""How the firmware treats what it receives; the real C++, on a clock turned by hand."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from tests.firmware.core import AXES, Core, Verdict
from tests.firmware.core_bench import AHEAD, SESSION, VECTORS, WRAP, Bench

from wax.robot.serial import frames
from wax.robot.serial.frames import (
    AxisBody,
    Decoder,
    DriveBody,
    Frame,
    HelloBody,
    MoveBody,
    ReportBody,
    StopBody,
    encode,
)

if TYPE_CHECKING:
    from wax.robot.serial.frames import Body


# The tests start the core's clock at its beginning, near its end, and across it.
CLOCKS = pytest.mark.parametrize("start_ms", [0, 123_456, WRAP - 100, WRAP - 1])


# --- bytes --------------------------------------------------------------------------------


@pytest.mark.parametrize("vector", VECTORS["valid"], ids=lambda vector: vector["name"])
def test_it_reads_and_writes_the_wire_vectors(vector: dict[str, Any]) -> None:
    """It understands what the server sends, and nothing that robots send."""
    wire = bytes.fromhex(vector["hex"])
    core = Core()
    greeting = encode(Frame(HelloBody(vector["session"])), 0)
    if vector["session"] != frames.NO_SESSION:
        assert len(core.hear(greeting, 0)) == 1
    found = [frame for frame, _ in core.hear(wire, vector["time_ms"])]
    body = getattr(frames, vector["type"] + "Body")(**vector["fields"])
    wanted = Frame(
        body,
        sequence=vector["sequence"],
        turn=vector["turn"],
        ttl_ms=vector["ttl_ms"],
        time_ms=vector["time_ms"],
    )
    assert found == ([] if isinstance(body, ReportBody) else [wanted])


@pytest.mark.parametrize("vector", VECTORS["ignored"], ids=lambda vector: vector["name"])
def test_what_is_no_frame_of_ours_is_ignored_and_counted(vector: dict[str, Any]) -> None:
    """A damaged or unknown frame only counts, and the next one is understood."""
    bench = Bench()
    found = bench.core.hear(bytes.fromhex(vector["hex"]), 0)
    found += bench.core.hear(encode(Frame(StopBody(), sequence=9), SESSION), 0)
    assert [frame.body for frame, _ in found] == [StopBody()]
    assert bench.core.damaged >= 1


octets = st.one_of(
    st.binary(max_size=60),
    st.lists(st.sampled_from([b"\xa5", b"\x5a", b"\xa5\x5a", b"\x00\x03", b"\x20"])).map(b"".join),
    st.builds(
        lambda body, sequence, cut: encode(Frame(body, sequence=sequence), SESSION)[cut:],
        st.sampled_from(
            [StopBody(), DriveBody(1, 2), AxisBody(1, 2), MoveBody(1, 2, 3), HelloBody(SESSION)]
        ),
        st.integers(0, 65_535),
        st.integers(0, 3),
    ),
)


@given(st.lists(octets, max_size=8).map(b"".join))
def test_both_languages_find_the_same_frames(wire: bytes) -> None:
    """In any bytes the core finds what the server's decoder finds, and counts the same damage."""
    decoder = Decoder(SESSION)
    bench = Bench()
    heard = [frame for frame, _ in bench.core.hear(wire, 0)]
    assert heard == decoder.feed(wire)
    assert bench.core.damaged == decoder.errors


@given(st.binary(max_size=300))
@example(bytes(300))
def test_bytes_that_nobody_asks_about_do_not_run_over(wire: bytes) -> None:
    """Pushed without asking, the core keeps one frame's bytes, and understands what comes later."""
    bench = Bench()
    bench.core.push(b"\xa5\x5a\x20" + wire)
    while bench.core.next(0):
        pass
    stop = encode(Frame(StopBody(), sequence=9), SESSION)
    assert [frame.body for frame, _ in bench.core.hear(stop * 4, 0)][-1:] == [StopBody()]


def test_a_report_says_how_it_is() -> None:
    """Every field of a report was given, counted or decided."""
    bench = Bench()
    bench.core.hear(b"\xa5\x5a\xff", 0)
    bench.say(AHEAD, turn=7)
    bench.say(AHEAD, turn=6)
    inputs = {"battery_mv": 7412, "bumpers": 2, "ticks": (-123_456, 2**31 - 1)}
    bench.wait(1, **inputs)
    frame = bench.report()
    assert frame is not None
    assert (frame.sequence, frame.turn, frame.time_ms) == (1, 7, 1)
    assert frame.body == ReportBody(7412, 2, -123_456, 2**31 - 1, 1, 2, damaged=1, refused=1)
    bench.wait(250, **inputs)
    frame = bench.report()
    assert frame is not None
    assert isinstance(frame.body, ReportBody)
    assert (frame.sequence, frame.body.timed_out, frame.body.moving) == (2, True, False)


# --- sessions -----------------------------------------------------------------------------


def test_without_hello_nothing_is_taken() -> None:
    """After a start it has no session: nothing moves it, and its reports say so."""
    core = Core()
    for session in (SESSION, frames.NO_SESSION - 1, 1, 0):
        assert core.hear(encode(Frame(AHEAD, sequence=1, ttl_ms=200), session), 0) == []
    core.tick(50)
    assert core.wheels_mmps == (0, 0)
    wire = core.report(50)
    assert len(Decoder(frames.NO_SESSION).feed(wire)) == 1
    assert Decoder(SESSION).feed(wire) == []


def test_hello_stops_and_forgets() -> None:
    """A hello stops, ends the old session, lets turns start over, and is answered at once."""
    bench = Bench()
    bench.wait(10)
    bench.told()
    assert bench.say(AHEAD, turn=9) is Verdict.TAKEN
    bench.wait(100)
    assert not bench.stands
    bench.session = 77
    bench.say(HelloBody(77), sequence=5)
    frame = bench.report()
    assert frame is not None
    assert isinstance(frame.body, ReportBody)
    assert frame.body.sequence == 5
    bench.wait(50)
    assert bench.stands
    assert bench.say(AHEAD, turn=9, session=SESSION) is None
    assert bench.say(AHEAD, turn=1) is Verdict.TAKEN


@CLOCKS
def test_what_was_said_before_hello_is_over(start_ms: int) -> None:
    """A motion from before its hello moves nothing when it is repeated, however young it is."""
    bench = Bench(start_ms)
    bench.wait(5)
    early = {"sequence": 9, "time_ms": bench.now_ms}
    bench.wait(5)
    bench.say(HelloBody(SESSION), sequence=1)
    assert bench.say(AHEAD, **early) is Verdict.LATE
    assert bench.say(AHEAD, sequence=10) is Verdict.TAKEN


# --- what is refused ----------------------------------------------------------------------


def test_the_past_turn_is_over() -> None:
    """A lower turn moves nothing but still stops; a higher turn's stop also ends the lower one."""
    bench = Bench()
    assert bench.say(AHEAD, turn=5) is Verdict.TAKEN
    assert bench.say(AHEAD, turn=4) is Verdict.OLD_TURN
    assert bench.say(AxisBody(0, 5), turn=4) is Verdict.OLD_TURN
    assert bench.say(StopBody(), turn=4) is Verdict.TAKEN
    bench.wait(50)
    assert bench.stands
    assert bench.say(AHEAD, turn=5) is Verdict.TAKEN
    assert bench.say(StopBody(), turn=6) is Verdict.TAKEN
    assert bench.say(AHEAD, turn=5) is Verdict.OLD_TURN
    assert bench.say(AHEAD, turn=WRAP - 1) is Verdict.TAKEN


@pytest.mark.parametrize("last", [1, 40_000, 65_535])
def test_only_what_is_newer_is_taken(last: int) -> None:
    """A sequence number 1 to 32767 ahead is newer, even across the wrap; all others are past."""
    for ahead, verdict in ((1, Verdict.TAKEN), (32_767, Verdict.TAKEN)):
        bench = Bench()
        bench.say(HelloBody(SESSION), sequence=last)
        assert bench.say(AHEAD, sequence=(last + ahead) & 0xFFFF) is verdict
    for ahead in (0, -1, 32_768, 65_535):
        bench = Bench()
        bench.say(HelloBody(SESSION), sequence=last)
        assert bench.say(AHEAD, sequence=(last + ahead) & 0xFFFF) is Verdict.OLD_SEQUENCE


def test_a_stop_ends_what_was_said_before_it() -> None:
    """A motion that a stop has overtaken is refused; repeating the stop does not bring it back."""
    bench = Bench()
    bench.say(StopBody(), sequence=20)
    assert bench.say(AHEAD, sequence=19) is Verdict.OLD_SEQUENCE
    assert bench.say(StopBody(), sequence=10) is Verdict.TAKEN
    assert bench.say(AHEAD, sequence=15) is Verdict.OLD_SEQUENCE
    assert bench.say(AHEAD, sequence=21) is Verdict.TAKEN


@CLOCKS
@pytest.mark.parametrize("ttl_ms", [20, 200, 1000])
def test_what_the_line_held_back_is_late(start_ms: int, ttl_ms: int) -> None:
    """A motion or an axis older than its time-to-live is refused; a stop never is."""
    bench = Bench(start_ms)
    bench.wait(3000)
    for body in (AHEAD, AxisBody(0, 1)):
        for age_ms, verdict in ((ttl_ms, Verdict.TAKEN), (ttl_ms + 1, Verdict.LATE)):
            time_ms = bench.now_ms - age_ms
            assert bench.say(body, ttl_ms=ttl_ms, time_ms=time_ms) is verdict
        for ahead_ms, verdict in ((50, Verdict.TAKEN), (51, Verdict.LATE), (5000, Verdict.LATE)):
            time_ms = bench.now_ms + ahead_ms
            assert bench.say(body, ttl_ms=ttl_ms, time_ms=time_ms) is verdict
    assert bench.say(StopBody(), time_ms=bench.now_ms - 60_000) is Verdict.TAKEN


def test_axes_go_where_they_are_told() -> None:
    """Each axis has its own position, within its range; an axis that does not exist is ignored."""
    bench = Bench()
    for number, position in ((0, 10_001), (1, -32_768), (3, 7), (AXES, 5), (255, 5)):
        assert bench.say(AxisBody(number, position)) is Verdict.TAKEN
    assert bench.core.axes == [10_000, -10_000, 0, 7]


# --- the watchdog -------------------------------------------------------------------------


@CLOCKS
@pytest.mark.parametrize(("ttl_ms", "worth_ms"), [(1, 1), (200, 200), (1000, 1000), (65_535, 1000)])
def test_a_motion_is_worth_its_time_to_live(start_ms: int, ttl_ms: int, worth_ms: int) -> None:
    """It counts from arrival, for at most a second, to the millisecond; and it is reported."""
    bench = Bench(start_ms, acceleration_mmps2=60_000, braking_mmps2=60_000)
    bench.say(DriveBody(60, -60), ttl_ms=ttl_ms)
    for _ in range(worth_ms - 1):
        bench.wait(1)
        assert bench.core.wheels_mmps == (60, -60)
        assert not bench.core.timed_out
    bench.wait(1)
    assert bench.stands
    assert bench.core.timed_out
    for body in (StopBody(), HelloBody(SESSION)):
        bench.say(body)
        assert not bench.core.timed_out
    bench.wait(500)
    assert not bench.core.timed_out


def test_that_its_watchdog_stopped_it_is_told_before_it_is_forgotten() -> None:
    """Even if the next motion arrives within a millisecond, the report comes first."""
    bench = Bench()
    bench.say(AHEAD, ttl_ms=210)
    for _ in range(209):
        bench.wait(1)
        bench.report()  # the last unprompted report is that of 200 ms
    bench.wait(1)
    frame = bench.report()
    assert frame is not None
    assert isinstance(frame.body, ReportBody)
    assert frame.body.timed_out


def test_a_motion_without_a_time_is_worth_nothing() -> None:
    """A time-to-live of 0 moves no wheel."""
    bench = Bench()
    bench.say(AHEAD, ttl_ms=0)
    bench.wait(50)
    assert bench.stands


def test_each_motion_is_worth_its_own_time() -> None:
    """Repeated motion continues, and ends one time-to-live after the last."""
    bench = Bench(WRAP - 1000)
    for _ in range(20):
        bench.say(AHEAD)
        bench.wait(150)
    assert bench.core.wheels_mmps == (600, 600)
    bench.wait(50 + 30)
    assert bench.stands
    assert bench.core.timed_out


@pytest.mark.parametrize("late_ms", [0, 1, 30, 5000])
@pytest.mark.parametrize("body", [AHEAD, DriveBody(0, 0), AxisBody(0, 10)])
def test_what_has_stopped_by_itself_does_not_go_on_by_itself(body: Body, late_ms: int) -> None:
    """After a time-to-live has expired nothing moves it until a stop or a hello."""
    for again in (StopBody(), HelloBody(SESSION)):
        bench = Bench()
        bench.say(AHEAD)
        bench.wait(199)
        bench.now_ms += 1  # the frame may be judged before the clock advances
        assert bench.say(body) is Verdict.TIMED_OUT
        bench.wait(late_ms)
        assert bench.say(body) is Verdict.TIMED_OUT
        bench.wait(30)
        assert bench.stands
        bench.say(again)
        assert bench.say(AHEAD) is Verdict.TAKEN
        bench.wait(30)
        assert not bench.stands


def test_it_can_be_driven_after_any_uptime() -> None:
    """A hundred days in one session, across two wraps, and it drives and expires as at first."""
    bench = Bench()
    for _ in range(10):
        bench.now_ms += 10 * 24 * 3600 * 1000
        bench.wait(2)
        assert bench.stands
        bench.say(StopBody())
        assert bench.say(AHEAD, time_ms=bench.now_ms - 100) is Verdict.TAKEN
        bench.wait(199)
        assert not bench.stands
        bench.wait(60)
        assert bench.stands


# --- the wheels ---------------------------------------------------------------------------

speeds = st.integers(-32_768, 32_767)


@given(
    st.integers(1, 65_535),
    st.integers(1, 65_535),
    st.lists(st.tuples(speeds, speeds, st.integers(0, 400)), min_size=1, max_size=8),
)
def test_the_ramp_is_never_exceeded(
    acceleration: int, braking: int, told: list[tuple[int, int, int]]
) -> None:
    """Each wheel is exactly as fast as its ramp allows, and never passes its target."""
    bench = Bench(WRAP - 700, acceleration_mmps2=acceleration, braking_mmps2=braking)
    oracle = [0, 0]
    for left, right, pause_ms in told:
        bench.say(DriveBody(left, right), ttl_ms=1000)
        for _ in range(pause_ms // 4):
            bench.now_ms += 4
            bench.core.tick(bench.now_ms)
            for wheel, target in enumerate((left, right)):
                oracle[wheel] = _ramped(oracle[wheel], target, acceleration, braking, 4)
                assert bench.core.wheels_mmps[wheel] == int(oracle[wheel] / 1000)


def _ramped(was: int, target: int, acceleration: int, braking: int, elapsed_ms: int) -> int:
    """Return the next speed in µm/s by an independent definition: towards the target, in parts."""
    target *= 1000
    if was * target < 0:
        target = 0
    slower = abs(target) < abs(was)
    step = (braking if slower else acceleration) * elapsed_ms
    return min(target, was + step) if target > was else max(target, was - step)


def test_a_stop_brakes_and_a_pause_does_not_jump() -> None:
    """600 mm/s end within 30 ms as configured; a second without a step counts as 20 ms."""
    bench = Bench(acceleration_mmps2=1000, braking_mmps2=20_000)
    bench.now_ms += 1000
    bench.say(AHEAD, ttl_ms=1000)
    bench.core.tick(bench.now_ms)
    assert bench.core.wheels_mmps == (20, 20)
    bench.wait(580)
    assert bench.core.wheels_mmps == (600, 600)
    bench.say(StopBody())
    bench.wait(29)
    assert bench.core.wheels_mmps == (20, 20)
    bench.wait(1)
    assert bench.stands


def test_a_pressed_bumper_stops_the_way_there() -> None:
    """It does not drive on towards what it has hit; away from it, and on the spot, it does."""
    ahead, back, spot = DriveBody(100, 60), DriveBody(-60, -100), DriveBody(80, -80)
    blocked = {(ahead, 1), (ahead, 3), (back, 2), (back, 3)}
    for body in (ahead, back, spot):
        for bumpers in range(8):
            bench = Bench()
            bench.say(body, ttl_ms=1000)
            bench.wait(200)
            assert bench.core.wheels_mmps == (body.left_mmps, body.right_mmps)
            bench.wait(50, bumpers=bumpers)
            assert bench.stands == ((body, bumpers & 3) in blocked), (body, bumpers)


def test_moving_is_what_the_wheels_do() -> None:
    """It moves from the first speed to an encoder's last tick; each change is reported at once."""
    bench = Bench(still_ms=50)
    assert bench.told().moving is False
    bench.say(AHEAD, ttl_ms=100)
    bench.wait(1)
    told = bench.report()
    assert told is not None
    assert isinstance(told.body, ReportBody)
    assert told.body.moving
    bench.wait(150)
    assert bench.stands
    assert bench.told().moving is False
    bench.wait(1, ticks=(1, 0))
    assert bench.core.moving
    bench.wait(1, ticks=(1, -1))
    bench.wait(49, ticks=(1, -1))
    assert bench.core.moving
    bench.told()
    bench.wait(1, ticks=(1, -1))
    assert not bench.core.moving
    assert bench.report() is not None


def test_one_wheel_is_motion_too() -> None:
    """A wheel that turns alone, either one, is motion."""
    for body in (DriveBody(0, 50), DriveBody(50, 0)):
        bench = Bench()
        bench.say(body)
        bench.wait(1)
        assert bench.core.moving


@CLOCKS
def test_reports_come_twenty_times_a_second(start_ms: int) -> None:
    """One comes every 50 ms, whatever happens or not."""
    bench = Bench(start_ms)
    bench.told()
    came = []
    for _ in range(500):
        bench.wait(1)
        if bench.report() is not None:
            came.append(bench.now_ms)
    assert [after - before for before, after in itertools.pairwise(came)] == [50] * 9
