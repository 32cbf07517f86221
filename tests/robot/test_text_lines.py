"""Lines in a stream of bytes, and a robot's reports in them."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.config.robot import RobotSettings
from wax.robot.serial.text_lines import MAX_LINE, Lines, Reports


def reports(*lines: str, **serial: Any) -> Reports:
    return Reports(
        RobotSettings.model_validate({"serial": {"text": {"reports": list(lines)}, **serial}})
    )


# --- lines --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("pieces", "lines"),
    [
        ([b"OK\r\n+\r", b"a b\n"], ["OK", "+", "a b"]),
        ([b"O", b"K", b"\r"], ["OK"]),
        ([b"\r\n\r\n  \r x \n"], ["x"]),
        ([b"\xff\x00\n"], ["\ufffd\x00"]),
        ([b"x" * MAX_LINE + b"\n"], ["x" * MAX_LINE]),
        ([b"x" * (MAX_LINE + 1) + b"\nOK\n"], ["OK"]),
        ([b"x" * MAX_LINE, b"x", b"yy", b"z\nOK\n"], ["OK"]),
        ([b"x" * 5000, b"\n", b"OK\n"], ["OK"]),
        ([b"x" * 5000, b"\n" + b"y" * 5000, b"z\nOK\n"], ["OK"]),
    ],
)
def test_lines_end_at_cr_or_lf(pieces: list[bytes], lines: list[str]) -> None:
    """A carriage return or line feed ends a line; empty and overlong ones are ignored."""
    found = Lines()
    assert [line for piece in pieces for line in found.feed(piece)] == lines


@given(st.binary(max_size=600), st.integers(1, 40))
def test_any_bytes_are_split_alike(data: bytes, size: int) -> None:
    """However a stream is cut, its lines are the same, and at most one is kept."""
    whole, cut = Lines(), Lines()
    pieces = [data[at : at + size] for at in range(0, len(data), size)]
    assert whole.feed(data) == [line for piece in pieces for line in cut.feed(piece)]
    assert len(cut._rest) <= MAX_LINE


# --- reports ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("template", "line"),
    [("V={battery_v}", "V=24.6"), ("V={battery_dv}", "V=246"), ("V={battery_mv}", "V=24600")],
)
def test_a_battery_is_read_in_any_unit(template: str, line: str) -> None:
    """Volts, tenths and thousandths all become volts."""
    told = reports(template)
    assert told.battery_v(0.0) is None
    assert told.parse_line(line, 0.0)
    assert told.battery_v(0.5) == 24.6


def test_old_values_expire() -> None:
    """After 1 s battery, bumpers and motion are unknown."""
    told = reports("{battery_v} {bumpers} {moving}")
    told.parse_line("12 3 1", 10.0)
    assert (told.battery_v(10.99), told.bumpers(10.99), told.moving(10.99)) == (12.0, 3, True)
    assert (told.battery_v(11.0), told.bumpers(11.0), told.moving(11.0)) == (None, 0, None)


def test_bumpers_are_bits() -> None:
    """The lowest eight bits of a number count."""
    told = reports("B{bumpers}")
    told.parse_line("B259", 0.0)
    assert told.bumpers(0.0) == 3


@pytest.mark.parametrize(
    ("template", "still", "turning"),
    [
        ("{moving}", "0", "1"),
        ("S={left}:{right}", "S=0:0", "S=0:-3"),
        ("S={left}:{right}", "S=0.0:0", "S=0.1:0"),
    ],
)
def test_motion_is_read(template: str, still: str, turning: str) -> None:
    """A flag or a speed shows whether a wheel turns."""
    told = reports(template)
    assert told.moving(0.0) is None
    told.parse_line(still, 0.0)
    assert told.moving(0.0) is False
    told.parse_line(turning, 0.1)
    assert told.moving(0.1) is True


def test_ticks_that_change_are_motion() -> None:
    """The newest two reports show whether a wheel turns."""
    told = reports("{left_ticks} {right_ticks}", ticks_per_m=1000)
    told.parse_line("5 5", 0.0)
    assert told.moving(0.0) is None
    told.parse_line("5 6", 0.2)
    assert told.moving(0.2) is True
    told.parse_line("5 6", 0.4)
    assert told.moving(0.4) is False
    assert told.moving(1.39) is False
    assert told.moving(1.41) is None
    assert told.known() == {"left_ticks": 5, "right_ticks": 6, "left_mps": 0, "right_mps": 0}
    assert told.pose is not None


FOUR = "{front_left_ticks} {front_right_ticks} {back_left_ticks} {back_right_ticks}"


def test_ticks_of_four_wheels_are_the_pose_of_a_mecanum_base() -> None:
    """They tell how far it moved sideways, whether it moves, and how fast each wheel turned."""
    serial = {"text": {"reports": [FOUR]}, "ticks_per_m": 1000.0}
    told = Reports(RobotSettings.model_validate({"base": "mecanum", "serial": serial}))
    told.parse_line("0 0 0 0", 0.0)
    told.parse_line("-100 100 100 -100", 0.2)
    assert told.moving(0.2) is True
    assert told.pose is not None
    assert (told.pose.x_m, told.pose.y_m) == pytest.approx((0.0, 0.1))
    assert told.known()["back_left_ticks"] == 100.0
    assert told.known()["front_left_mps"] == pytest.approx(-0.5)


def test_a_flag_alone_does_not_hide_ticks() -> None:
    """Either sign of motion is enough."""
    told = reports("{moving} {left_ticks} {right_ticks}")
    told.parse_line("0 1 1", 0.0)
    told.parse_line("0 2 1", 0.1)
    assert told.moving(0.1) is True


def test_another_line_is_ignored() -> None:
    """A line that does not match changes nothing."""
    told = reports("V={battery_v}", "B={bumpers}")
    assert not told.parse_line("V=x", 0.0)
    assert told.parse_line("B=1", 0.0)
    assert (told.battery_v(0.0), told.bumpers(0.0), told.known()) == (None, 1, {})


def test_a_new_connection_knows_nothing() -> None:
    """Earlier values do not count."""
    told = reports("{left_ticks} {right_ticks}", "V={battery_v}")
    for line in ("1 1", "2 2", "V=12"):
        told.parse_line(line, 0.0)
    told.forget()
    assert (told.battery_v(0.0), told.moving(0.0), told.known()) == (None, None, {})


@pytest.mark.parametrize("wrong", ["", "nan", "-inf", "ovf", "NULL"])
@pytest.mark.parametrize("at", range(4))
def test_each_number_of_a_line_counts_for_itself(at: int, wrong: str) -> None:
    """An invalid number does not affect the others in its line, and is not taken for motion."""
    told = reports("R {battery_mv},{bumpers},{left_ticks},{right_ticks}")
    assert told.parse_line("R 12000,1,0,0", 1.0)
    second = ["12100", "1", "9", "9"]
    second[at] = wrong
    assert told.parse_line("R " + ",".join(second), 1.5)
    assert told.battery_v(1.5) == (12.0 if at == 0 else 12.1)
    assert told.bumpers(1.5) == 1
    assert told.moving(1.5) is (None if at > 1 else True)
    assert told.battery_v(2.2) == (None if at == 0 else 12.1)


def test_of_two_matching_patterns_the_longer_counts() -> None:
    """In whatever order they are configured, that with more numbers does."""
    patterns = ["{left},{right} 12000", "{left},{bumpers} {battery_mv}"]
    for told in (reports(*patterns), reports(*reversed(patterns))):
        assert told.parse_line("1,4 12000", 1.0)
        assert (told.bumpers(1.0), told.battery_v(1.0)) == (4, 12.0)


def test_what_is_seldom_asked_expires_later() -> None:
    """Two and a half rounds of questions, here of two, after it was told."""
    told = Reports(
        RobotSettings.model_validate(
            {"serial": {"text": {"reports": ["V={battery_v}"], "ask": ["v", "w"], "ask_ms": 1000}}}
        )
    )
    told.parse_line("V=12", 10.0)
    assert (told.battery_v(14.99), told.battery_v(15.0)) == (12.0, None)


def test_zero_volts_are_unknown() -> None:
    """As in the dialect `frames`, a board without a divider sends 0."""
    told = reports("V {battery_mv}")
    assert told.parse_line("V 0", 1.0)
    assert told.battery_v(1.0) is None
