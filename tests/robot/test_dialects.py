"""When the two dialects say what, on a clock turned by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from wax.config import BytesDialectSettings, RobotSettings
from wax.robot.driver import STANDSTILL, Limits, Twist
from wax.robot.serial.framed import FramedDialect
from wax.robot.serial.frames import Axis, Body, Decoder, Drive, Frame, Hello, Report, Stop, encode
from wax.robot.serial.setpoints import Order
from wax.robot.serial.single_byte import SingleByteDialect
from wax.robot.serial.wheels import Mixer

LIMITS = Limits(linear_mps=0.6, angular_rps=1.5)
STAND = Order(STANDSTILL, 1)


def going(ahead: float, left: float, turn: int = 1) -> Order:
    """Shares of the limits."""
    return Order(Twist(ahead * LIMITS.linear_mps, left * LIMITS.angular_rps), turn)


def framed() -> FramedDialect:
    return FramedDialect(Mixer(RobotSettings()), ttl_ms=200, axes=("pan", "lamp"))


def single() -> SingleByteDialect:
    """Give the dialect of single bytes after its hello and all its stops, at time 1."""
    dialect = SingleByteDialect(BytesDialectSettings(), LIMITS)
    dialect.hello(0.0)
    for now_s in (0.0, 0.02, 0.04, 0.06):
        dialect.say(STAND, now_s)
    return dialect


def says(
    dialect: SingleByteDialect | FramedDialect, order: Order, now_s: float
) -> tuple[bytes, float]:
    words, due_s = dialect.say(order, now_s)
    return words, round(due_s, 6)


def bodies(wire: bytes) -> list[Body]:
    return [frame.body for frame in Decoder().feed(wire)]


# --- frames -------------------------------------------------------------------------------


def test_frames_begin_with_hello_and_stop() -> None:
    """A fresh connection makes the robot forget and stand."""
    assert bodies(framed().hello(0.0)) == [Hello(), Stop()]


def test_frames_are_sent_on_change_and_four_times_a_ttl() -> None:
    """A change goes out at once, the same again every quarter of the time-to-live."""
    dialect = framed()
    assert bodies(dialect.say(going(1, 0), 1.0)[0]) == [Drive(600, 600)]
    assert says(dialect, going(1, 0), 1.04) == (b"", 1.05)
    assert bodies(dialect.say(going(1, 0), 1.05)[0]) == [Drive(600, 600)]
    assert bodies(dialect.say(going(-1, 0), 1.051)[0]) == [Drive(-600, -600)]
    words, due_s = dialect.say(STAND, 1.06)
    assert bodies(words) == [Stop()]
    assert due_s == pytest.approx(1.11)
    assert bodies(dialect.say(STAND, 1.11)[0]) == [Stop()]


def test_frames_carry_turn_ttl_and_a_rising_sequence() -> None:
    """Every frame has its number; a drive has its turn and how long it is worth."""
    dialect = framed()
    wire = dialect.hello(0.0)
    wire += dialect.say(going(0.5, 0, turn=8), 1.0)[0] + dialect.say(going(0.5, 0, turn=9), 1.0)[0]
    found = Decoder().feed(wire)
    assert [frame.sequence for frame in found] == [1, 2, 3, 4]
    assert [(frame.turn, frame.ttl_ms) for frame in found[2:]] == [(8, 200), (9, 200)]


def test_frames_move_axes() -> None:
    """An axis that was ever set is said with every frame, as ten-thousandths of its range."""
    order = replace(STAND, axes=(("pan", -0.5),))
    assert bodies(framed().say(order, 0.0)[0]) == [Stop(), Axis(0, -5000)]


def test_axes_are_numbered_by_their_place() -> None:
    """The first name of the configuration is axis 0, the next 1, in whatever order they are set."""
    order = replace(STAND, axes=(("lamp", 1.0), ("pan", 0.0)))
    assert bodies(framed().say(order, 0.0)[0]) == [Stop(), Axis(1, 10_000), Axis(0, 0)]


def test_frames_say_farewell_with_a_stop() -> None:
    """The last word is a stop of the turn that ran."""
    dialect = framed()
    dialect.say(going(1, 0, turn=4), 0.0)
    assert Decoder().feed(dialect.farewell())[0] == Frame(Stop(), sequence=2, turn=4)


def test_reports_are_known_until_the_next_connection() -> None:
    """What the robot reports is known by name, errors are counted, and a new line begins anew."""
    dialect = framed()
    assert dialect.known() == {"line_errors": 0.0}
    report = Report(7412, 2, -10, 20, 1, 77)
    dialect.hear(b"\xa5\x5a\xff" + encode(Frame(report)) + encode(Frame(Drive(1, 1))))
    assert dialect.known() == {
        "line_errors": 1.0,
        "battery_v": 7.412,
        "bumpers": 2.0,
        "left_ticks": -10.0,
        "right_ticks": 20.0,
        "moving": 1.0,
        "timed_out": 0.0,
        "last_sequence": 77.0,
    }
    dialect.hello(0.0)
    assert dialect.known() == {"line_errors": 0.0}


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
    assert single().say(going(ahead, left), 1.0)[0][-1:] == byte


def test_bytes_are_sent_only_on_change() -> None:
    """A held key is one byte; its speed goes before it when that changes."""
    dialect = single()
    said = [
        dialect.say(going(ahead, left), 1.0 + n * 0.02)[0]
        for n, (ahead, left) in enumerate(
            [(0.3, 0), (0.3, 0), (0.31, 0.01), (0.3, 0.3), (1, 1), (1, 1), (1, 0), (0.3, 0)]
        )
    ]
    assert said == [b"1F", b"", b"", b"G", b"2G", b"", b"F", b"1F"]
    assert dialect.say(going(0.3, 0), 99.0) == (b"", math.inf)


def test_stop_is_said_three_times() -> None:
    """A stop goes out at once and twice more 20 ms apart, and then there is silence."""
    dialect = single()
    dialect.say(going(1, 0), 1.0)
    assert says(dialect, STAND, 2.0) == (b"S", 2.02)
    assert says(dialect, STAND, 2.01) == (b"", 2.02)
    assert says(dialect, STAND, 2.02) == (b"S", 2.04)
    assert dialect.say(STAND, 2.04) == (b"S", math.inf)
    assert dialect.say(STAND, 2.06) == (b"", math.inf)


def test_a_new_motion_ends_the_stops() -> None:
    """No stop byte comes after the byte of a motion that followed it."""
    dialect = single()
    dialect.say(going(1, 0), 1.0)
    dialect.say(STAND, 2.0)
    assert dialect.say(going(1, 0), 2.01) == (b"F", math.inf)
    assert dialect.say(going(1, 0), 2.03) == (b"", math.inf)


def test_almost_nothing_is_standstill() -> None:
    """Less than a twentieth of the limits does not creep."""
    assert single().say(going(0.04, -0.04), 1.0)[0] == b""


def test_a_board_without_speeds_gets_none() -> None:
    """Without bytes for the speeds only directions are sent."""
    dialect = SingleByteDialect(BytesDialectSettings(fine=None, gross=None), LIMITS)
    dialect.hello(0.0)
    assert dialect.say(going(0.3, 0), 1.0)[0] == b"F"
    assert dialect.say(going(1, 0), 1.1)[0] == b""


def test_a_new_connection_says_all_anew() -> None:
    """After a hello the speed is said again, because the board may have restarted."""
    dialect = single()
    dialect.say(going(1, 0), 1.0)
    assert dialect.hello(2.0) == b"S"
    assert dialect.say(STAND, 2.03)[0] == b"S"
    assert dialect.say(going(1, 0), 2.1)[0] == b"2F"


def test_bytes_say_farewell_with_three_stops() -> None:
    """The last word is the stop, three times."""
    assert single().farewell() == b"SSS"
    assert single().known() == {}
