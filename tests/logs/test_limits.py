"""Strangers can make the server log neither much nor any terminal control codes."""

from __future__ import annotations

import logging
from typing import Any

import pytest

from wax.logs.limits import RepeatLimit, add_left_out, tidy


def record(event: object = "viewer gone", lineno: int = 1) -> logging.LogRecord:
    msg = event if isinstance(event, str) else {"event": event}
    return logging.LogRecord("wax", logging.INFO, "x.py", lineno, msg, None, None)


class Rig:
    """A rate limit with a fake clock."""

    def __init__(self) -> None:
        self.now_s = 0.0
        self.limit = RepeatLimit(lambda: self.now_s)

    def passed(self, count: int, **what: Any) -> int:
        return sum(self.limit.filter(record(**what)) for _ in range(count))


def test_a_flood_of_one_kind_is_cut() -> None:
    """A kind may log a hundred lines, then one a second; other kinds are not limited by it."""
    rig = Rig()
    assert rig.passed(1000, event="a") == 100
    assert rig.passed(5, event="b", lineno=2) == 5
    rig.now_s += 10
    assert rig.passed(1000, event="a") == 10
    rig.now_s += 10_000
    assert rig.passed(1000, event="a") == 100


def test_our_events_are_kinds_wherever_they_come_from() -> None:
    """Our events are limited by name, a library's by line of code, since its texts may vary."""
    rig = Rig()
    for number in range(300):
        rig.limit.filter(record(f"strange packet {number}", lineno=7))
    assert rig.passed(1, event="strange packet x", lineno=7) == 0
    ours = logging.LogRecord("wax", logging.INFO, "x.py", 1, {"event": "viewer gone"}, None, None)
    assert sum(rig.limit.filter(ours) for _ in range(300)) == 100


def test_what_was_left_out_is_told() -> None:
    """The next line of a kind says how many were left out."""
    rig = Rig()
    rig.passed(150)
    rig.now_s += 1
    line = record()
    assert rig.limit.filter(line)
    assert add_left_out(None, "", {"_record": line}) == {"_record": line, "left_out": 50}
    assert add_left_out(None, "", {"_record": record()}).keys() == {"_record"}


@pytest.mark.parametrize("event", ["text", {"event": "ours", "exc_info": True}])
def test_a_line_after_a_flood_has_no_traceback(event: Any) -> None:
    """A line after a flood has no traceback: a flood of them would fill the disk."""
    rig = Rig()
    error = ValueError()
    lines: list[tuple[logging.LogRecord, bool]] = []
    for _ in range(102):
        line = logging.LogRecord("x", logging.ERROR, "x.py", 1, event, None, None)
        line.exc_info = (ValueError, error, None)
        rig.now_s += 1 if len(lines) == 101 else 0
        lines.append((line, rig.limit.filter(line)))
    assert [line.exc_info is not None for line, passed in lines if passed] == [True] * 100 + [False]
    assert "exc_info" not in str(lines[-1][0].msg)


def test_the_kinds_do_not_grow_without_end() -> None:
    """The table of kinds is bounded."""
    rig = Rig()
    for number in range(5000):
        rig.limit.filter(record(lineno=number))
    assert len(rig.limit._kinds) <= 1000


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (3, 3),
        (None, None),
        (True, True),
        ("Zoë", "Zoë"),
        ("\x1b]0;evil\x07\n", r"\x1b]0;evil\x07\n"),
        ("\u202eevil", r"\u202eevil"),
        (["\x1b"], r"['\x1b']"),
        (ValueError("\n"), r"ValueError('\n')"),
        ("x" * 1000, "x" * 299 + "…"),
    ],
)
def test_values_are_bounded_and_visible(value: object, shown: object) -> None:
    """Numbers stay numbers; any other value becomes one short, visible line."""
    assert tidy(None, "", {"value": value}) == {"value": shown}


def test_a_traceback_keeps_its_lines() -> None:
    """A traceback keeps its lines and its end, without terminal control codes."""
    trace = "\n".join(["File x"] * 5000 + ["ValueError: \x1b[31m"])
    told = tidy(None, "", {"exception": trace})["exception"]
    assert told.endswith("File x\nValueError: \\x1b[31m")
    assert len(told) <= 8010
