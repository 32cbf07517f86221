"""Lines with numbers in them: written, parsed, and refused if they are more than that."""

from __future__ import annotations

import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.config.line_template import LineTemplate

NAMES = ("left", "right")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("m {left} {right}\r", b"m -12 3\r"),
        ("m {left:d} {right:+05d}\r\n", b"m -12 +0003\r\n"),
        ("<{left:.2f},{right:.0f}>", b"<-12.40,3>"),
        ("{{{left:6}}}", b"{   -12}"),
        ("{right:f}", b"2.600000"),
        ("!EX\r", b"!EX\r"),
        ("", b""),
    ],
)
def test_each_place_is_said_as_its_format_has_it(text: str, said: bytes) -> None:
    """Each number is written in its format: rounded, or with decimals; doubled braces are one."""
    assert LineTemplate(text, NAMES).said({"left": -12.4, "right": 2.6}) == said


@pytest.mark.parametrize("text", ["{left}", "{left:.2f}", "{left:+.1f}"])
def test_nothing_is_minus_nothing(text: str) -> None:
    """A number that rounds to zero has no minus sign, which a sketch may look for."""
    assert b"-" not in LineTemplate(text, NAMES).said({"left": -0.001})


@pytest.mark.parametrize(
    ("text", "ending"), [("a\r", "\r"), ("a\r\n", "\r\n"), ("\n", "\n"), ("a;", ""), ("{left}", "")]
)
def test_its_end_is_known(text: str, ending: str) -> None:
    """Only carriage returns and line feeds end a line."""
    assert LineTemplate(text, NAMES).ending == ending


@pytest.mark.parametrize(
    ("text", "line", "found"),
    [
        ("e {left} {right}\r", "e -12 +7.5", {"left": -12.0, "right": 7.5}),
        ("{left}", "0.", {"left": 0.0}),
        ("V={_}:{left}", "V=135:246", {"_": 135.0, "left": 246.0}),
        ("OK\r\n", "OK", {}),
        ("a.c", "abc", None),
        (" m {left} \r", "m 1", {"left": 1.0}),
        (" OK ", "OK", {}),
        ("a\\\r", "a\\", {}),
        ("{left}", "", None),
        ("{left}", "1e5", None),
        ("{left}", "1" * 13, None),
        ("{left} {right}", "1 2 3", None),
        ("{left}.{right}", "1.2.3", {"left": 1.2, "right": 3.0}),
        ("{left}1", "11", None),
        ("V {left},{right}", "V nan,7", {"right": 7.0}),
        ("V {left},{right}", "V ,7", {"right": 7.0}),
        ("V {left},{right}", "V -inf,OVF", {}),
        ("V {left},{right}", "V nana,7", None),
        ("V {left},{right}", "V ,", None),
    ],
)
def test_a_line_is_understood_as_it_is_described(
    text: str, line: str, found: dict[str, float] | None
) -> None:
    """A line matches if its fields are numbers or empty, and all other text is the same."""
    assert LineTemplate(text, (*NAMES, "_")).found(line) == found


@given(st.integers(-(10**6), 10**6), st.integers(-(10**6), 10**6))
def test_what_is_said_is_understood(left: int, right: int) -> None:
    """A written line parses to its numbers."""
    template = LineTemplate("m {left} {right:.1f}\r", NAMES)
    numbers = {"left": left, "right": right}
    assert template.found(template.said(numbers).decode().strip()) == numbers


@pytest.mark.parametrize("between", ["", " ", "1", ".", "-"])
def test_no_line_takes_long(between: str) -> None:
    """No line takes long to parse, whatever a robot sends."""
    template = LineTemplate(between.join(["{_}"] * 20), ("_",))
    began_s = time.thread_time()
    for letter in "1.-":
        template.found(letter * 5000 + "x")
    assert time.thread_time() - began_s < 0.5


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("m {left.real}", "{left.real} is more than a name; possible are: {left}, {right}"),
        ("m {left[0]}", "{left[0]} is more than a name"),
        ("m {left!r}", "{left!r} is more than a name"),
        ("m {left.__class__.__mro__}", "is more than a name"),
        ("m {0}", "{0} is more than a name"),
        ("m {}", "there is no {} here"),
        ("m {lift}", "there is no {lift} here; possible are: {left}, {right}"),
        ("m {left:{right}}", "is no format for a number; write {left} for a whole number,"),
        ("m {left:.2}", "{left:.2} is no format for a number"),
        ("m {left:>9}", "is no format for a number"),
        ("m {left:999999d}", "is no format for a number"),
        ("m {left:.9f}", "is no format for a number"),
        ("m {left", "has a brace without its other half; write {{ or }}"),
        ("m }", "has a brace without its other half"),
        ("m {left}\\r", "has a backslash, not an end of line; write it in double quotes"),
        ("m {left}é", "has characters that are not ASCII"),
        ("m" * 121, "is 121 characters long; a line has at most 120"),
    ],
)
def test_what_is_more_than_a_line_is_refused(text: str, why: str) -> None:
    """Attributes, indices, conversions, other formats and typos are refused with what to write."""
    with pytest.raises(ValueError, match=r".") as refused:
        LineTemplate(text, NAMES)
    assert why in str(refused.value)


def test_a_line_without_places_says_so() -> None:
    """A line that may have no fields is refused with "none" as the possible ones."""
    with pytest.raises(ValueError, match=r"there is no \{left\} here; possible are: none"):
        LineTemplate("{left}", ())
