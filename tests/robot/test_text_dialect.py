"""What the dialect `text` sends and when, on a manual clock."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.config.robot import RobotSettings
from wax.driver.interface import STANDSTILL, Limits, Reading, Twist
from wax.robot.line.setpoints import Order
from wax.robot.serial.text_dialect import TextDialect
from wax.robot.wheels import WheelMixer

STAND = Order(STANDSTILL, 1)
AHEAD = Order(Twist(0.5, 0.0), 1)
LEFT = Order(Twist(0.0, 1.0), 1)
STOP = b"m 0 0\r"
GO = b"m 500 500\r"


def dialect(robot: dict[str, Any] | None = None, baud: int = 4_000_000, **text: Any) -> TextDialect:
    """Give one that is fast enough not to matter, whose board listens at once."""
    lines = {"drive": "m {left} {right}\r", "per_mps": 1000.0, "boot_ms": 0} | text
    axes = [f"axis_{number}" for number in range(len(text.get("axis", [])))]
    serial = {"dialect": "text", "baud": baud, "text": lines, "axes": axes}
    settings = RobotSettings.model_validate({"serial": serial, **(robot or {})})
    limits = Limits(
        settings.max_linear_mps,
        settings.max_angular_rps,
        axes=tuple(axes),
        lateral_mps=settings.lateral_mps,
    )
    return TextDialect(settings, WheelMixer(settings), limits)


def begun(**text: Any) -> TextDialect:
    """Give one whose board has listened since 1, at 1.01."""
    found = dialect(**text)
    found.hello(1.0)
    found.data_to_send(STAND, 1.001)
    if "answers" in text:
        found.receive_data(b"OK\r\n", 1.002)
        found.data_to_send(STAND, 1.003)
        found.receive_data(b"OK\r\n", 1.004)
    assert found.answers(1.01)
    return found


def says(one: TextDialect, order: Order, now_s: float) -> tuple[bytes, float]:
    words, due_s = one.data_to_send(order, now_s)
    return words, round(due_s, 3)


# --- the line -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "order", "line"),
    [
        ({}, AHEAD, b"m 500 500\r"),
        ({}, LEFT, b"m -150 150\r"),
        ({"per_mps": 40.0}, Order(Twist(-0.33, 0.0), 1), b"m -13 -13\r"),
        ({"drive": "{left:.2f},{right:.2f}\n", "per_mps": 1.0}, AHEAD, b"0.50,0.50\n"),
        ({"limit": 100.0}, Order(Twist(0.45, 1.0), 1), b"m 50 100\r"),
        ({"limit": 500.0}, AHEAD, b"m 500 500\r"),
        (
            {"drive": "v {linear:.1f} {angular:.1f}\n", "per_mps": 1.0, "per_rps": 57.3},
            LEFT,
            b"v 0.0 57.3\n",
        ),
        (
            {"drive": "{linear} {angular}\n", "per_mps": 100.0, "per_rps": 100.0, "limit": 50.0},
            LEFT,
            b"0 50\n",
        ),
    ],
)
def test_a_motion_is_said_to_scale(text: dict[str, Any], order: Order, line: bytes) -> None:
    """A motion is sent in the template's units and format, never beyond its limit."""
    assert begun(**text).data_to_send(order, 1.01)[0] == line


MIXED = {"drive": "m {front_left} {front_right} {back_left} {back_right}\r"}
TOLD = {"drive": "{linear} {lateral} {angular}\n", "per_mps": 1000.0, "per_rps": 1000.0}


@pytest.mark.parametrize(
    ("base", "text", "twist", "line"),
    [
        ("mecanum", MIXED, Twist(0.0, 0.0, 0.5), b"m -500 500 500 -500\r"),
        ("mecanum", MIXED, Twist(0.3, 0.0, 0.3), b"m 0 600 600 0\r"),
        ("mecanum", MIXED | {"limit": 300.0}, Twist(0.3, 0.0, 0.3), b"m 0 300 300 0\r"),
        ("omni", {"drive": "{left} {right} {back}\n"}, Twist(0.0, 0.0, 0.4), b"-200 200 400\n"),
        ("mecanum", TOLD, Twist(0.3, 0.1, -0.2), b"300 -200 100\n"),
        ("mecanum", TOLD | {"limit": 100.0}, Twist(0.3, 0.1, -0.2), b"100 -67 33\n"),
    ],
)
def test_a_motion_sideways_is_said_to_scale(
    base: str, text: dict[str, Any], twist: Twist, line: bytes
) -> None:
    """The line has all wheels of the base, or the robot's speed sideways beside the others."""
    one = dialect({"base": base, "wheel_base_m": 0.3}, **text)
    one.hello(1.0)
    one.data_to_send(STAND, 1.001)
    assert one.data_to_send(Order(twist, 1), 1.01)[0] == line


def test_limits_trim_and_direction_are_the_robots() -> None:
    """The wheels' limits, trim and inversion apply here, too."""
    robot = {"left_trim": 0.5, "invert_right": True, "max_linear_mps": 0.4}
    one = dialect(robot)
    one.hello(1.0)
    one.data_to_send(STAND, 1.001)
    assert one.data_to_send(AHEAD, 1.01)[0] == b"m 200 -400\r"


def test_change_is_said_at_once_and_all_else_again_and_again() -> None:
    """A change is sent at once, and the newest line, even standstill, is repeated each interval."""
    one = begun()
    words, due_s = one.data_to_send(AHEAD, 1.01)
    assert words == GO
    assert due_s == pytest.approx(1.11)
    assert says(one, AHEAD, 1.1) == (b"", 1.11)
    assert says(one, AHEAD, 1.11) == (GO, 1.21)
    assert says(one, LEFT, 1.12) == (b"m -150 150\r", 1.22)
    assert says(one, STAND, 1.13) == (STOP, 1.23)
    for number in range(1, 100):
        assert says(one, STAND, 1.131 + number / 9.9)[0] == STOP


def test_a_stop_line_of_its_own() -> None:
    """A configured stop line replaces zeros, also at the start and the end."""
    one = dialect(stop="x\r")
    assert one.hello(1.0) == b"\rx\r"
    assert one.data_to_send(STAND, 1.001)[0] == b"x\r"
    assert one.data_to_send(AHEAD, 1.01)[0] == GO
    assert one.data_to_send(STAND, 1.02)[0] == b"x\r"
    assert one.farewell() == b"\rx\rx\rx\r"


def test_a_turn_that_begins_with_motion_begins_with_a_stop() -> None:
    """If the stop between two turns was not sent it is sent first, but never twice."""
    one = begun()
    assert one.data_to_send(AHEAD, 1.01)[0] == GO
    assert one.data_to_send(Order(AHEAD.twist, 2), 1.02)[0] == STOP + GO
    assert one.data_to_send(Order(AHEAD.twist, 2), 1.03)[0] == b""
    assert one.data_to_send(Order(LEFT.twist, 3), 1.04)[0] == STOP + b"m -150 150\r"
    assert one.data_to_send(Order(STANDSTILL, 4), 1.05)[0] == STOP
    assert one.data_to_send(Order(AHEAD.twist, 5), 1.06)[0] == GO
    assert one.data_to_send(Order(LEFT.twist, 5), 1.07)[0] == b"m -150 150\r"


@given(st.floats(-5, 5), st.floats(-20, 20), st.sampled_from([0.0, 1.0, 255.0]))
def test_no_number_is_more_than_the_limit(ahead: float, left: float, limit: float) -> None:
    """For any motion both numbers are whole, and within the limit where there is one."""
    one = begun(limit=limit)
    words = one.data_to_send(Order(Twist(ahead, left), 1), 1.2)[0]
    numbers = [int(word) for word in words.decode().split()[1:]]
    assert len(numbers) == 2
    assert max(map(abs, numbers)) <= (limit or 1000.0)


# --- the line's time ----------------------------------------------------------------------


def test_on_a_slow_line_nothing_waits_in_a_buffer() -> None:
    """At 300 bit/s a line takes a third of a second; meanwhile only the newest one is kept."""
    settings: dict[str, Any] = {"drive": "m {left} {right}\r", "per_mps": 1000.0, "boot_ms": 0}
    serial = {"dialect": "text", "baud": 300, "text": settings}
    robot = RobotSettings.model_validate({"serial": serial})
    one = TextDialect(robot, WheelMixer(robot), Limits(0.6, 1.5))
    assert len(one.hello(1.0)) == 7
    assert says(one, AHEAD, 1.2) == (b"", 1.233)
    assert one.data_to_send(AHEAD, 1.24)[0] == STOP  # it listens from now on
    assert says(one, AHEAD, 1.25) == (b"", 1.44)
    assert says(one, AHEAD, 1.45) == (GO, 1.783)
    assert says(one, LEFT, 1.5) == (b"", 1.783)
    assert says(one, STAND, 1.784)[0] == STOP


# --- the beginning and the end ------------------------------------------------------------


def test_a_board_that_starts_is_told_to_stop() -> None:
    """A booting board gets only stops, then the lines of `begin` and a stop, then motion."""
    one = dialect(boot_ms=250, begin=["^RWD 500\r", "!MG\r"])
    assert one.hello(1.0) == b"\r" + STOP
    assert not one.answers(1.0)
    assert says(one, AHEAD, 1.05) == (b"", 1.1)
    assert says(one, AHEAD, 1.1) == (STOP, 1.2)
    assert says(one, AHEAD, 1.201) == (STOP, 1.25)
    assert not one.answers(1.249)
    assert says(one, AHEAD, 1.25) == (b"^RWD 500\r!MG\r" + STOP, 1.35)
    assert one.answers(1.25)
    assert not one.overdue(99.0)
    assert one.data_to_send(AHEAD, 1.26)[0] == GO


def test_a_new_connection_begins_anew() -> None:
    """A new connection waits for the board again and sends everything again."""
    one = dialect(boot_ms=100, begin=["b\r"], axis=[{"line": "s{position}\r"}])
    order = Order(STANDSTILL, 1, axes=(("axis_0", 1.0),))
    for began_s in (1.0, 2.0):
        assert one.hello(began_s) == b"\r" + STOP
        assert not one.answers(began_s + 0.05)
        assert one.data_to_send(order, began_s + 0.1)[0] == b"b\r" + STOP
        assert one.data_to_send(order, began_s + 0.15)[0] == b"s1\r"


def test_before_the_first_connection_nothing_is_known() -> None:
    """A line that was never opened is not there."""
    one = dialect(answers="OK", boot_ms=2000)
    assert not one.answers(0.0)
    assert one.reading == Reading(extra={"strange_lines": 0.0})


def test_the_last_word_is_a_stop_three_times() -> None:
    """The farewell is three stops, unharmed by an incomplete line before it."""
    assert begun(end=["!EX\r", "bye\r"]).farewell() == b"\r" + STOP * 3 + b"!EX\rbye\r"
    assert begun(drive="<{left},{right}>").farewell() == b"<0,0>" * 3


# --- answers ------------------------------------------------------------------------------


def test_a_board_that_must_answer_is_waited_for() -> None:
    """A board that must answer gets stops until it does, and then the lines of `begin`."""
    one = dialect(answers="OK", begin=["b\r"], boot_ms=300)
    assert one.hello(1.0) == b"\r" + STOP
    assert says(one, AHEAD, 1.1) == (STOP, 1.2)
    one.receive_data(b"Ready.\r\nO", 1.12)
    assert says(one, AHEAD, 1.13) == (b"", 1.2)
    one.receive_data(b"K\r\n", 1.14)
    assert not one.answers(1.14)
    assert says(one, AHEAD, 1.15) == (b"b\r" + STOP, 1.25)
    assert not one.answers(1.15)
    assert one.data_to_send(AHEAD, 1.25)[0] == STOP
    one.receive_data(b"OK\n", 1.26)
    assert one.answers(1.26)
    assert one.data_to_send(AHEAD, 1.27)[0] == GO


def test_a_board_that_never_answers_is_missed() -> None:
    """A board that never answers counts as lost after the timeout, and gets only stops."""
    one = dialect(answers="OK", boot_ms=300)
    one.hello(1.0)
    assert (one.overdue(1.799), one.overdue(1.8)) == (False, True)
    for number in range(20):
        assert says(one, AHEAD, 1.1 + number / 9.9)[0] == STOP
    assert not one.answers(3.0)
    one.receive_data(b"OK\n", 3.01)
    one.data_to_send(AHEAD, 3.02)
    one.receive_data(b"OK\n", 3.03)
    assert one.answers(3.03)
    assert not one.overdue(3.03)


def test_a_board_that_falls_silent_is_gone() -> None:
    """A board that stops answering counts as lost, and the connection starts over with a stop."""
    one = begun(answers="OK", begin=["b\r"])
    assert one.data_to_send(AHEAD, 1.01)[0] == GO
    one.receive_data(b"OK\n", 1.3)
    assert (one.answers(1.799), one.overdue(1.799)) == (True, False)
    assert (one.answers(1.8), one.overdue(1.8)) == (False, True)
    assert says(one, AHEAD, 1.79) == (GO, 1.8)
    assert one.data_to_send(AHEAD, 1.8)[0] == b"\r" + STOP
    assert not one.answers(1.81)
    one.receive_data(b"OK\n", 1.82)
    assert one.data_to_send(AHEAD, 1.83)[0] == b"b\r" + STOP


@pytest.mark.parametrize("answered_s", [1.1, 1.2])
def test_begun_and_never_answered_again(answered_s: float) -> None:
    """A board that answers only before the lines of `begin` counts as lost, too."""
    one = dialect(answers="OK", begin=["b\r"])
    one.hello(1.0)
    one.receive_data(b"OK\n", answered_s)
    one.data_to_send(AHEAD, 1.2)
    assert not one.answers(1.2)
    assert (one.overdue(1.69), one.overdue(1.7)) == (False, True)
    assert one.data_to_send(AHEAD, 1.7)[0] == b"\r" + STOP


def test_another_line_is_no_answer() -> None:
    """A wrong line is counted, and the complaint quotes it, made harmless."""
    one = dialect(answers="OK")
    one.hello(1.0)
    assert one.complaint("/dev/x").code == "robot.no_lines"
    one.receive_data(b"Invalid Command\x1b[2J" + b"!" * 60 + b"\r\nNOT OK\n", 1.1)
    assert not one.answers(1.1)
    assert one.reading.extra == {"strange_lines": 2.0}
    complaint = one.complaint("/dev/x")
    assert complaint.code == "robot.other_answer"
    assert complaint.values == {"port": "/dev/x", "said": "NOT OK"}
    one.receive_data(b"Invalid Command\x1b[2J" + b"!" * 60 + b"\r\n", 1.2)
    said = one.complaint("/dev/x").values["said"]
    assert said == "Invalid Command\\x1b[2J!!!!!!!!!!!!!!!!!…"
    one.receive_data(b"OK\n", 1.3)
    assert one.complaint("/dev/x").code == "robot.no_lines"
    one.receive_data(b"?\n", 1.4)
    one.hello(2.0)
    assert one.complaint("/dev/x").code == "robot.no_lines"


def test_a_board_that_need_not_answer_is_there() -> None:
    """Whatever it says or does not say."""
    one = begun()
    one.receive_data(b"\xff\x00\r\n", 2.0)
    assert (one.answers(99.0), one.overdue(99.0)) == (True, False)
    assert one.reading.extra == {"strange_lines": 1.0}


# --- questions, reports and axes ----------------------------------------------------------


def test_questions_are_asked_in_turn() -> None:
    """In each interval the next question follows the motion, starting with the first."""
    one = begun(ask=["e\r", "v\r"], ask_ms=150)
    assert says(one, STAND, 1.01) == (b"v\r", 1.101)
    assert says(one, STAND, 1.101) == (STOP, 1.16)
    assert says(one, AHEAD, 1.16) == (GO + b"e\r", 1.26)
    assert says(one, AHEAD, 1.26) == (GO, 1.31)
    assert says(one, AHEAD, 1.31)[0] == b"v\r"


def test_on_a_slow_port_no_stop_waits_behind_a_question() -> None:
    """While a line takes 83 ms nothing else is sent; the question comes alone, later."""
    one = dialect(baud=1200, ask=["e\r"], ask_ms=100)
    one.hello(1.0)
    one.data_to_send(STAND, 1.1)
    assert one.data_to_send(AHEAD, 1.3)[0] == GO
    assert one.data_to_send(AHEAD, 1.39)[0] == b"e\r"


def test_what_is_seldom_asked_is_known_until_it_is_asked_again() -> None:
    """Two and a half rounds of questions, a second at least."""
    one = begun(ask=["v\r"], ask_ms=2000, reports=["V={battery_v}"])
    one.receive_data(b"V=12.5\n", 1.02)
    one.data_to_send(STAND, 6.0)
    assert one.reading.battery_v == 12.5
    one.data_to_send(STAND, 6.1)
    assert one.reading.battery_v is None


def test_reports_are_its_state() -> None:
    """What a line tells is known, and is no answer; an answer may be a report as well."""
    one = begun(answers="OK", reports=["V={battery_v}", "B{bumpers}", "{left_ticks} {right_ticks}"])
    one.receive_data(b"V=12.5\nB2\n1 1\n1 2\n", 1.02)
    assert (one.reading.battery_v, one.reading.bumpers, one.reading.moving) == (12.5, 2, True)
    assert one.reading.extra == {"left_ticks": 1.0, "right_ticks": 2.0, "strange_lines": 0.0}
    one.data_to_send(STAND, 2.1)
    assert (one.reading.battery_v, one.reading.bumpers, one.reading.moving) == (None, 0, None)
    also = begun(answers="OK", reports=["V={battery_v}"])
    also.receive_data(b"V=1\n", 1.6)
    assert not also.answers(1.6)


def test_a_place_is_known_where_ticks_have_a_length() -> None:
    """The pose comes from the ticks of the lines."""
    serial = {
        "dialect": "text",
        "ticks_per_m": 100.0,
        "text": {
            "drive": "{left} {right}",
            "per_mps": 1.0,
            "reports": ["{left_ticks}/{right_ticks}"],
        },
    }
    robot = RobotSettings.model_validate({"serial": serial})
    one = TextDialect(robot, WheelMixer(robot), Limits(0.6, 1.5))
    one.receive_data(b"0/0\n", 1.0)
    one.receive_data(b"50/50\n", 2.0)
    assert one.reading.pose is not None
    assert one.reading.pose.x_m == 0.5
    assert one.reading.extra["left_mps"] == 0.5


def test_axes_move_when_they_are_told() -> None:
    """Each has its own range, and its line follows the motion once per new position."""
    one = begun(
        axis=[
            {"line": "s 0 {position}\r", "least": 180.0, "most": 0.0},
            {"line": "t{position:.1f}\r"},
        ]
    )
    order = Order(AHEAD.twist, 1, axes=(("axis_1", 0.25), ("axis_0", -1.0)))
    assert one.data_to_send(order, 1.01)[0] == GO + b"t0.2\rs 0 180\r"
    assert one.data_to_send(order, 1.02)[0] == b""
    moved = Order(AHEAD.twist, 1, axes=(("axis_1", 0.25), ("axis_0", 0.0)))
    assert one.data_to_send(moved, 1.03)[0] == b"s 0 90\r"


@given(st.lists(st.tuples(st.binary(max_size=40), st.floats(0, 2)), max_size=12))
def test_no_bytes_raise_or_move_it(heard: list[tuple[bytes, float]]) -> None:
    """Whatever a robot sends, a dialect that must stand sends nothing but stop."""
    one = dialect(answers="OK", reports=["{left_ticks} {right_ticks}", "V={battery_v}"])
    said, now_s = one.hello(1.0), 1.0
    for data, pause_s in heard:
        now_s += pause_s
        one.receive_data(data, now_s)
        words, due_s = one.data_to_send(STAND, now_s)
        said += words
        assert due_s > now_s, "it would be asked without a pause"
        assert one.reading.moving in (None, True, False)
    assert set(said.split(b"\r")) <= {b"", STOP[:-1]}
