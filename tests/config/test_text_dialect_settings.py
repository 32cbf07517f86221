"""The lines of `[robot.serial.text]`: what is refused, with which sentence."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from wax.clock import SystemClock
from wax.config import settings as config
from wax.errors import ConfigError
from wax.robot.build_driver import make_driver
from wax.robot.serial.advice import advised

if TYPE_CHECKING:
    from wax.config.serial import SerialSettings

CONFIG = Path(__file__).parents[2] / "config"
GOOD: dict[str, Any] = {"drive": "m {left} {right}\r", "per_mps": 1000.0}


def parsed(text: dict[str, Any], **serial: Any) -> SerialSettings:
    own = {"dialect": "text", "text": text} | serial
    tree = {"robot": {"driver": "serial", "serial": own}}
    return config.parse(tree, "x").robot.serial


@pytest.mark.parametrize("name", ["ros-arduino-bridge", "roboteq"])
def test_the_examples_are_safe_ones(name: str) -> None:
    """The examples load without a warning: they have a known watchdog and ask for answers."""
    robot = config.load(CONFIG / f"{name}.toml").robot
    assert robot.driver == "serial"
    assert robot.serial.dialect == "text"
    assert advised(robot.serial) == []
    assert robot.serial.text.answers


def test_a_line_and_its_scale_are_enough() -> None:
    """All other keys have defaults, and no watchdog is assumed."""
    text = parsed(GOOD).text
    assert (text.stop, text.answers, text.ttl_ms) == ("", "", 0)


def test_every_line_may_be_written() -> None:
    """A table with all keys loads as written."""
    text = GOOD | {
        "stop": "!EX\r",
        "begin": ["^ECHOF 1\r"],
        "end": ["!EX\r"],
        "ask": ["?V 2\r"],
        "reports": ["V={battery_dv}", "{left_ticks}:{right_ticks}"],
        "axis": [{"line": "s {position}\r", "least": 180.0, "most": 0.0}],
    }
    found = parsed(text, axes=["pan"]).text.model_dump()
    assert {key: found[key] for key in text} == text


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"drive": ""}, "robot.serial: text.drive is missing: it is the line"),
        ({"drive": "go\r"}, "text.drive: 'go\\r' has no place for a speed"),
        ({"drive": "m {left}\r"}, "text.drive: 'm {left}\\r' has no {right}"),
        ({"drive": "m {angular}\r"}, "has no {linear}; without it the robot cannot steer"),
        ({"drive": "m {left.x} {right}\r"}, "text.drive: {left.x} is more than a name"),
        ({"stop": "{left}"}, "text.stop: there is no {left} here; possible are: none"),
        ({"answers": "{"}, "text.answers: '{' has a brace without its other half"),
        ({"begin": ["ok\r", "{a}"]}, "text.begin: there is no {a} here"),
        ({"end": ["{a}"]}, "text.end: there is no {a} here"),
        ({"ask": ["é"]}, "text.ask: 'é' has characters that are not ASCII"),
        ({"reports": ["{volt}"]}, "text.reports: there is no {volt} here"),
        ({"reports": ["V={_}"]}, "text.reports: 'V={_}' tells nothing"),
        ({"reports": ["{left_ticks}"]}, "the ticks of all wheels must be in one line"),
        ({"drive": "{linear} {lateral}\r"}, "has no {angular}; without it the robot cannot steer"),
        ({"drive": "{lateral}\r"}, "has no {linear}; without it the robot cannot steer"),
        ({"drive": "{front_left} {back_left}"}, "has no {front_right}; without it"),
        ({"drive": "{left} {back}"}, "has no {right}; without it the robot cannot steer"),
        ({"drive": "{left} {front_left}"}, "no base has the wheels left, front_left"),
        ({"reports": ["{left_ticks} {back_ticks}"]}, "has no {right_ticks}; the ticks of all"),
        (
            {"drive": "{left} {right} {back}"},
            'robot: serial.text.drive has the wheels left, right, back, but base = "differential"'
            " has left, right; write those, or another base",
        ),
        (
            {
                "reports": [
                    "{front_left_ticks} {front_right_ticks}{back_left_ticks}{back_right_ticks}"
                ]
            },
            "robot: serial.text.reports has the wheels front_left, front_right, back_left, back_ri",
        ),
        ({"axis": [{"line": "s\r"}]}, "text.axis[0].line: has no {position}"),
        ({"axis": [{"line": "s{position}\r"}]}, "axes has 0 names and text.axis 1 lines"),
        ({"per_mps": 0.0}, "robot.serial.text: per_mps is missing: what number"),
        (
            {"drive": "{linear} {angular}\r", "per_mps": 1.0},
            "robot.serial.text: per_rps is missing: what number",
        ),
        ({"ttl_ms": 150}, "keep_alive_ms is 100 and ttl_ms 150; say the line at least twice"),
        ({"answers": "OK", "answer_ms": 150}, "keep_alive_ms is 100 and answer_ms 150; an answer"),
        ({"drive": "m" * 121}, "got"),
        ({"begin": [""]}, "text.begin[0]: got"),
        ({"ttl_ms": -1}, "text.ttl_ms: got -1; allowed is a whole number from 0 to 10000"),
    ],
)
def test_what_is_wrong_is_one_sentence(change: dict[str, Any], why: str) -> None:
    """A mistake is one sentence with the key, what is wrong, and what to write."""
    with pytest.raises(ConfigError) as refused:
        parsed(GOOD | change)
    message = str(refused.value)
    assert message.count("\n") == 1, message
    assert why in message


@pytest.mark.parametrize(
    ("base", "drive", "is_told"),
    [
        ("differential", "{left} {right}", False),
        ("differential", "{linear} {angular}", False),
        ("differential", "{linear} {lateral} {angular}", True),
        ("mecanum", "{front_left} {front_right} {back_left} {back_right}", True),
        ("mecanum", "{linear} {angular}", False),
        ("omni", "{left} {right} {back}", True),
    ],
)
def test_a_board_moves_sideways_if_its_line_says_so(
    base: str, drive: str, *, is_told: bool
) -> None:
    """The line has {lateral}, or the wheels of such a base; else it is quoted and refused."""
    text = {"drive": drive, "per_mps": 1000.0, "per_rps": 1000.0}
    serial = {"dialect": "text", "text": text}
    robot = {"driver": "serial", "base": base, "max_lateral_mps": 0.4, "serial": serial}
    settings = config.parse({"robot": robot}, "x").robot
    assert settings.serial.text.moves_sideways == is_told
    if is_told:
        assert make_driver(settings, SystemClock()).limits.lateral_mps == 0.4
    else:
        with pytest.raises(ConfigError) as refused:
            make_driver(settings, SystemClock())
        assert f'serial.text.drive = "{drive}" has no {{lateral}}' in str(refused.value)


def test_a_place_for_sideways_needs_a_speed() -> None:
    """Two sides do not say whether the robot can: a line with {lateral} would always say 0."""
    text = {"drive": "{linear} {lateral} {angular}", "per_mps": 1.0, "per_rps": 1.0}
    robot = {"driver": "serial", "serial": {"dialect": "text", "text": text}}
    with pytest.raises(ConfigError, match=r"max_lateral_mps is missing: .*\{lateral\}"):
        config.parse({"robot": robot}, "x")
    for told in ({"max_lateral_mps": 0}, {"max_lateral_mps": 0.4}, {"base": "mecanum"}):
        config.parse({"robot": robot | told}, "x")


def test_lines_of_another_dialect_need_not_be_whole() -> None:
    """Only the dialect in use must have what it needs."""
    assert parsed({}, dialect="frames", axes=["pan"]).text.drive == ""


@pytest.mark.parametrize(("ttl_ms", "keep_alive_ms"), [(0, 1000), (200, 100), (40, 20)])
def test_a_watchdog_has_the_time_of_two_lines(ttl_ms: int, keep_alive_ms: int) -> None:
    """A watchdog of twice the interval is accepted; without one, any interval is."""
    text = GOOD | {"ttl_ms": ttl_ms, "keep_alive_ms": keep_alive_ms}
    assert parsed(text).text.ttl_ms == ttl_ms
