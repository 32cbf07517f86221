"""What the two dialects send and when, on a manual clock."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest
from tests.robot.dialect_robot import LIMITS, Robot, connected, framed, going, says

from wax.config.serial import BytesDialectSettings
from wax.driver.interface import STANDSTILL, Reading
from wax.robot.line.setpoints import Order
from wax.robot.serial.bytes_dialect import BytesDialect
from wax.robot.serial.frames import (
    AxisBody,
    DriveBody,
    Frame,
    HelloBody,
    ReportBody,
    StopBody,
    encode,
)

if TYPE_CHECKING:
    from wax.robot.serial.frames_dialect import FramesDialect

STAND = Order(STANDSTILL, 1)


def single() -> BytesDialect:
    """Give the dialect of single bytes after its hello and all its stops, at time 1."""
    dialect = BytesDialect(BytesDialectSettings(), LIMITS)
    dialect.hello(0.0)
    for now_s in (0.0, 0.02, 0.04, 0.06):
        dialect.data_to_send(STAND, now_s)
    return dialect


# --- frames -------------------------------------------------------------------------------


def test_frames_begin_with_hello_and_stop() -> None:
    """A fresh connection makes the robot forget and stand; each has a session of its own."""
    dialect, robot = framed(), Robot()
    first = robot.hear(dialect.hello(0.0))
    assert [type(body) for body in first] == [HelloBody, StopBody]
    assert robot.hear(dialect.hello(1.0))[0] != first[0]


def test_until_it_answers_the_robot_gets_hello_and_stop() -> None:
    """Until the robot answers, the session is offered every 100 ms, and no motion is sent."""
    dialect, robot = framed(), Robot()
    first = robot.hear(dialect.hello(1.0))
    assert not dialect.answers(1.0)
    assert says(dialect, going(1, 0), 1.05) == (b"", 1.1)
    words, due_s = says(dialect, going(1, 0), 1.1)
    assert (robot.hear(words), due_s) == (first, 1.2)
    assert (dialect.overdue(1.4), dialect.overdue(1.5)) == (False, True)
    assert says(dialect, going(1, 0), 1.6)[1] == 1.7


def test_an_answer_is_one_to_what_was_said() -> None:
    """A report of another session, or of no frame of the last half second, connects nothing."""
    dialect, robot = framed(), Robot()
    robot.hear(dialect.hello(1.0))
    report = ReportBody(0, 0, 0, 0, 0, robot.heard[-1].sequence)
    for session in (0xFFFF, robot.decoder.session ^ 1):
        dialect.receive_data(encode(Frame(report), session), 1.0)
    robot.answer(dialect, 1.0, sequence=99)
    assert not dialect.answers(1.0)
    robot.answer(dialect, 1.5)
    assert not dialect.answers(1.5)
    robot.answer(dialect, 1.49)
    assert dialect.answers(1.49)


@pytest.mark.parametrize("deaf", [False, True])
def test_a_silence_begins_a_new_session(deaf: bool) -> None:
    """Half a second after the last acknowledged frame, hello is sent instead of motion."""
    dialect, robot = connected(1.0)
    session = robot.decoder.session
    taken = robot.heard[-1].sequence
    for now_s in (1.1, 1.2, 1.3, 1.4, 1.49):
        robot.hear(dialect.data_to_send(going(1, 0), now_s)[0])
        if deaf:
            robot.answer(dialect, now_s, sequence=taken)
    assert says(dialect, going(1, 0), 1.495) == (b"", 1.5)
    found = robot.hear(dialect.data_to_send(going(1, 0), 1.5)[0])
    assert [type(body) for body in found] == [HelloBody, StopBody]
    assert robot.decoder.session != session
    assert not dialect.answers(1.5)
    robot.answer(dialect, 1.51)
    assert dialect.answers(1.51)


def test_frames_are_sent_on_change_and_fifty_times_a_second() -> None:
    """A change is sent at once, the same motion again every 20 ms, standstill every 50 ms."""
    dialect, robot = connected(1.0)
    assert robot.hear(dialect.data_to_send(going(1, 0), 1.0)[0]) == [DriveBody(600, 600)]
    assert says(dialect, going(1, 0), 1.01) == (b"", 1.02)
    assert robot.hear(dialect.data_to_send(going(1, 0), 1.02)[0]) == [DriveBody(600, 600)]
    assert robot.hear(dialect.data_to_send(going(-1, 0), 1.021)[0]) == [DriveBody(-600, -600)]
    words, due_s = dialect.data_to_send(STAND, 1.03)
    assert robot.hear(words) == [StopBody()]
    assert due_s == pytest.approx(1.08)
    assert robot.hear(dialect.data_to_send(STAND, 1.08)[0]) == [StopBody()]


def test_frames_carry_turn_ttl_and_a_rising_sequence() -> None:
    """Every frame has a rising number, and a drive frame its turn and time-to-live."""
    dialect, robot = connected(1.0)
    robot.hear(dialect.data_to_send(going(0.5, 0, turn=8), 1.0)[0])
    robot.hear(dialect.data_to_send(going(0.5, 0, turn=9), 1.0)[0])
    assert [frame.sequence for frame in robot.heard] == [1, 2, 3, 4, 5]
    told = [(frame.turn, frame.ttl_ms) for frame in robot.heard[2:]]
    assert told == [(8, 200), (9, 0), (9, 200)]


def test_frames_carry_the_robots_time() -> None:
    """A frame's time is the last report's plus the time since, across the clock's wrap."""
    dialect, robot = connected(1.0, time_ms=2**32 - 100)
    robot.hear(dialect.data_to_send(going(1, 0), 1.06)[0])
    robot.hear(dialect.data_to_send(going(1, 0), 1.25)[0])
    robot.answer(dialect, 1.3, time_ms=7000)
    robot.hear(dialect.data_to_send(going(1, 0), 1.35)[0])
    robot.hear(dialect.hello(2.0))
    assert [frame.time_ms for frame in robot.heard] == [0, 0, 2**32 - 40, 150, 7050, 0, 0]


def test_frames_move_axes() -> None:
    """An axis, once set, is sent with every set-point, in ten-thousandths of its range."""
    order = replace(STAND, axes=(("pan", -0.5),))
    dialect, robot = connected()
    assert robot.hear(dialect.data_to_send(order, 1.0)[0]) == [StopBody(), AxisBody(0, -5000)]
    assert robot.heard[-1].ttl_ms == 200


def test_axes_are_numbered_by_their_place() -> None:
    """The first name of the configuration is axis 0, the next 1, in whatever order they are set."""
    order = replace(STAND, axes=(("lamp", 1.0), ("pan", 0.0)))
    dialect, robot = connected()
    assert robot.hear(dialect.data_to_send(order, 1.0)[0]) == [
        StopBody(),
        AxisBody(1, 10_000),
        AxisBody(0, 0),
    ]


def test_frames_say_farewell_with_a_stop() -> None:
    """The farewell is a stop of the current turn."""
    dialect, robot = connected()
    robot.hear(dialect.data_to_send(going(1, 0, turn=4), 1.0)[0])
    assert robot.hear(dialect.farewell()) == [StopBody()]
    assert robot.heard[-1].turn == 4


def test_reports_are_known_until_the_next_connection() -> None:
    """What the robot reports is known by name, errors are counted, and a new line begins anew."""
    dialect, robot = connected()
    dialect.receive_data(
        b"\xa5\x5a\xff" + encode(Frame(DriveBody(1, 1)), robot.decoder.session), 1.0
    )
    report = {"battery_mv": 7412, "bumpers": 2, "left_ticks": -10, "right_ticks": 20, "flags": 1}
    robot.answer(dialect, 1.0, **report, damaged=3, refused=4)
    assert dialect.reading.extra == {
        "line_errors": 1.0,
        "left_ticks": -10.0,
        "right_ticks": 20.0,
        "moving": 1.0,
        "timed_out": 0.0,
        "last_sequence": 2.0,
        "robot_line_errors": 3.0,
        "robot_refused": 4.0,
    }
    reading = dialect.reading
    assert (reading.moving, reading.bumpers, reading.battery_v) == (True, 2, 7.412)
    dialect.hello(2.0)
    assert dialect.reading == Reading(extra={"line_errors": 0.0})


def test_what_came_before_the_session_is_no_error_of_the_line() -> None:
    """Errors are counted from the first answer on."""
    dialect, robot = framed(), Robot()
    robot.hear(dialect.hello(1.0))
    dialect.receive_data(encode(Frame(ReportBody(0, 0, 0, 0, 0, 0)), 0xFFFF), 1.0)
    assert dialect.reading.extra == {"line_errors": 1.0}
    robot.answer(dialect, 1.0)
    assert dialect.reading.extra["line_errors"] == 0.0


# --- bytes --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("ahead", "left", "byte"),
    [
        (1, 0, b"F"), (-1, 0, b"B"), (0, 1, b"L"), (0, -1, b"R"),
        (1, 1, b"G"), (1, -1, b"I"), (-1, 1, b"H"), (-1, -1, b"J"),
        (1, 0.3, b"F"), (1, -0.3, b"F"), (-0.2, -0.9, b"R"), (0.5, 0.6, b"G"),
    ],
)  # fmt: skip
def test_each_direction_is_its_byte(ahead: float, left: float, byte: bytes) -> None:
    """Eight directions, each the sector of 45 degrees that the set-point lies in."""
    assert single().data_to_send(going(ahead, left), 1.0)[0][-1:] == byte


def test_bytes_are_sent_only_on_change() -> None:
    """A held key sends one byte; a changed speed is sent before it."""
    dialect = single()
    said = [
        dialect.data_to_send(going(ahead, left), 1.0 + n * 0.02)[0]
        for n, (ahead, left) in enumerate(
            [(0.3, 0), (0.3, 0), (0.31, 0.01), (0.3, 0.3), (1, 1), (1, 1), (1, 0), (0.3, 0)]
        )
    ]
    assert said == [b"1F", b"", b"", b"G", b"2G", b"", b"F", b"1F"]
    assert dialect.data_to_send(going(0.3, 0), 99.0) == (b"", math.inf)


def test_stop_is_said_three_times() -> None:
    """A stop is sent at once and twice more, 20 ms apart, and then nothing."""
    dialect = single()
    dialect.data_to_send(going(1, 0), 1.0)
    assert says(dialect, STAND, 2.0) == (b"S", 2.02)
    assert says(dialect, STAND, 2.01) == (b"", 2.02)
    assert says(dialect, STAND, 2.02) == (b"S", 2.04)
    assert dialect.data_to_send(STAND, 2.04) == (b"S", math.inf)
    assert dialect.data_to_send(STAND, 2.06) == (b"", math.inf)


def test_a_new_motion_ends_the_stops() -> None:
    """After a new motion no more bytes of the previous stop are sent."""
    dialect = single()
    dialect.data_to_send(going(1, 0), 1.0)
    dialect.data_to_send(STAND, 2.0)
    assert dialect.data_to_send(going(1, 0), 2.01) == (b"F", math.inf)
    assert dialect.data_to_send(going(1, 0), 2.03) == (b"", math.inf)


def test_almost_nothing_is_standstill() -> None:
    """Less than a twentieth of the limits counts as standstill; a twentieth does not."""
    assert single().data_to_send(going(0.04, -0.04), 1.0)[0] == b""
    assert single().data_to_send(going(0.05, 0), 1.0)[0] == b"1F"


def test_half_of_the_limits_is_fine_still() -> None:
    """Only above half of the limits the coarse command is sent."""
    assert single().data_to_send(going(0.5, 0), 1.0)[0] == b"1F"
    assert single().data_to_send(going(0.51, 0), 1.0)[0] == b"2F"


def test_a_turn_that_begins_with_motion_begins_with_the_stop_byte() -> None:
    """If the stop between two turns was not sent it is sent first, but never twice."""
    dialect = single()
    dialect.data_to_send(going(1, 0, turn=1), 1.0)
    assert says(dialect, going(1, 0, turn=2), 1.01) == (b"SF", math.inf)
    assert says(dialect, going(-0.2, 0, turn=3), 1.02) == (b"S1B", math.inf)
    assert says(dialect, going(1, 0, turn=3), 1.03) == (b"2F", math.inf)
    assert says(dialect, replace(STAND, turn=4), 1.04) == (b"S", 1.06)
    assert says(dialect, going(1, 0, turn=5), 1.05) == (b"F", math.inf)


def test_a_board_without_speeds_gets_none() -> None:
    """Without bytes for the speeds only directions are sent."""
    dialect = BytesDialect(BytesDialectSettings(fine=None, gross=None), LIMITS)
    dialect.hello(0.0)
    assert dialect.data_to_send(going(0.3, 0), 1.0)[0] == b"F"
    assert dialect.data_to_send(going(1, 0), 1.1)[0] == b""


def test_a_board_with_one_speed_gets_that() -> None:
    """Where the other has no byte the direction goes alone."""
    dialect = BytesDialect(BytesDialectSettings(fine=None), LIMITS)
    dialect.hello(0.0)
    assert dialect.data_to_send(going(1, 0), 1.0)[0] == b"2F"
    assert dialect.data_to_send(going(0.3, 0), 1.1)[0] == b"F"


def test_a_new_connection_says_all_anew() -> None:
    """After a reconnection the speed is sent again, because the board may have restarted."""
    dialect = single()
    dialect.data_to_send(going(1, 0), 1.0)
    assert dialect.hello(2.0) == b"S"
    assert dialect.data_to_send(STAND, 2.03)[0] == b"S"
    assert dialect.data_to_send(going(1, 0), 2.1)[0] == b"2F"


def test_bytes_say_farewell_with_three_stops() -> None:
    """The farewell is three stops."""
    assert single().farewell() == b"SSS"
    assert single().reading.extra == {}


@pytest.mark.parametrize("dialect", [framed(), single()])
def test_a_silent_board_is_named_by_its_port(dialect: BytesDialect | FramesDialect) -> None:
    """Of a board that says nothing nothing is known, neither whether it moves nor where it is."""
    complaint = dialect.complaint("/dev/x")
    assert (complaint.code, complaint.values) == ("robot.no_answer_on", {"port": "/dev/x"})
    assert dialect.reading.moving is None
    assert dialect.reading.pose is None


def test_bytes_boards_need_not_answer() -> None:
    """Such a board is there as long as its port is; whether it moves nobody knows."""
    dialect = single()
    dialect.receive_data(b"ok", 1.0)
    assert (dialect.answers(99.0), dialect.overdue(99.0)) == (True, False)
    assert dialect.reading == Reading()
