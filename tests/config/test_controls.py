"""`[[controls]]` and `[[gauges]]`: what is refused, with which sentence."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from wax.config import settings as config
from wax.config.controls import DRIVING_KEYS, LATERAL_KEYS
from wax.errors import ConfigError

ROOT = Path(__file__).parents[2]
LAMP = '[[controls]]\nname = "lamp"\nkind = "toggle"\n'
ARM = '[[controls]]\nname = "arm"\nkind = "slider"\n'
GRIP = '[[controls]]\nname = "grip"\nkind = "choice"\n'
HEAT = '[[gauges]]\nname = "motor_c"\n'


def _parsed(text: str) -> config.Settings:
    return config.parse(tomllib.loads(text), "robot.toml")


def _problem(text: str) -> str:
    with pytest.raises(ConfigError) as refused:
        _parsed(text)
    heading, *problems = str(refused.value).splitlines()
    assert heading == "robot.toml: 1 problem:"
    (problem,) = problems
    return problem.strip()


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (
            '[[controls]]\nname = "lamp"',
            'controls[0].kind: is missing; allowed is "button", "toggle", "slider" or "choice"',
        ),
        (
            '[[controls]]\nname = "my lamp"\nkind = "toggle"',
            'controls[0].name: got "my lamp"; allowed is '
            "a name of at most 16 letters, digits and _, not beginning with a digit",
        ),
        (LAMP + "lable = 'x'", "controls[0].lable: there is no such key; did you mean label?"),
        (
            LAMP + "max = 5.0",
            "controls[0]: lamp is a toggle, which has no max; leave it out, or write"
            ' kind = "slider"',
        ),
        (
            LAMP + 'choices = ["a", "b"]',
            'controls[0]: lamp is a toggle, which has no choices; write kind = "choice"',
        ),
        *[
            (
                ARM + bounds,
                f"controls[0]: arm goes from {said}; max must be above min by a step at least",
            )
            for bounds, said in [
                ("min = 1.0", "1 to 1 in steps of 0.05"),
                ("min = 2.0", "2 to 1 in steps of 0.05"),
                ("max = 2.0\nstep = 3.0", "0 to 2 in steps of 3"),
            ]
        ],
        *[
            (
                GRIP + choices,
                "controls[0]: grip needs two choices at least, each with words of its own",
            )
            for choices in ("", 'choices = ["open"]', 'choices = ["open", "shut", "open"]')
        ],
        (
            LAMP + 'key = "KeyW"',
            "controls[0]: lamp has the key KeyW, which drives or stops already",
        ),
        (
            LAMP + 'key = "Escape"',
            "controls[0]: lamp has the key Escape, which browsers need themselves",
        ),
        (
            LAMP + 'key = "H!"',
            'controls[0].key: got "H!"; allowed is '
            'empty, or a key by its place on the keyboard, as "KeyH" or "Digit1"',
        ),
        *[
            (ARM + pressed, "controls[0]: arm is a slider, which no single key can set")
            for pressed in ('key = "KeyH"', 'pad_button = "X"')
        ],
        (
            LAMP + 'pad_button = "B"',
            'controls[0].pad_button: got "B"; allowed is "", "X", "Y", "LB", "RB", "View", "LS" or'
            ' "RS"',
        ),
        (
            LAMP + "moves = true",
            "controls[0]: lamp moves, so it must be held; a toggle cannot be: write kind ="
            ' "button" or "slider"',
        ),
        (
            ARM + 'moves = true\nroles = ["operator", "observer"]',
            'controls[0]: arm moves, so it is for whoever drives alone: write roles = ["operator"]',
        ),
        (
            LAMP + 'roles = ["guest"]',
            'controls[0].roles[0]: got "guest"; allowed is "operator", "host" or "observer"',
        ),
        (LAMP + LAMP, "controls: two have the name lamp; give each its own"),
        (
            LAMP + 'key = "KeyH"\n' + LAMP.replace("lamp", "siren") + 'key = "KeyH"',
            "controls: two have the key KeyH; give each its own",
        ),
        (
            LAMP + 'pad_button = "X"\n' + LAMP.replace("lamp", "siren") + 'pad_button = "X"',
            "controls: two have the pad_button X; give each its own",
        ),
        (HEAT + HEAT, "gauges: two have the name motor_c; give each its own"),
        (HEAT + "min = 100.0", "gauges[0]: motor_c goes from 100 to 100; max must be above min"),
        (
            HEAT + "warn_above = 90.0\nstop_above = 80.0",
            "gauges[0]: motor_c: warn_above is 90 and stop_above 80; "
            "stop_above must be the larger one",
        ),
        (
            HEAT + "stop_below = 20.0\nstop_above = 20.0",
            "gauges[0]: motor_c: stop_below is 20 and stop_above 20; "
            "stop_above must be the larger one",
        ),
        (
            HEAT + "stop_above = nan",
            "gauges[0].stop_above: got nan; allowed is a number from -10000 to 10000",
        ),
    ],
)
def test_mistakes_are_told(text: str, problem: str) -> None:
    """Each mistake is one line that names the control, what is wrong, and what to write."""
    assert _problem(text) == problem


def test_a_limit_that_warns_may_be_the_one_that_stops() -> None:
    """A gauge may warn and stop at the same limit."""
    (gauge,) = _parsed(HEAT + "warn_above = 80.0\nstop_above = 80.0").gauges
    assert gauge.may_stop


@pytest.mark.parametrize(
    ("text", "is_held"),
    [
        (LAMP, False),
        (LAMP.replace("toggle", "button"), True),
        (ARM, False),
        (ARM + "moves = true", True),
    ],
)
def test_what_must_be_held(text: str, is_held: bool) -> None:
    """A button, and any control that moves, must be held."""
    (control,) = _parsed(text).controls
    assert control.is_held is is_held


def test_no_control_can_have_a_key_of_driving() -> None:
    """The refused keys are exactly the page's own default keys."""
    source = (ROOT / "web/src/drive/keyMap.ts").read_text(encoding="utf-8")
    (table,) = re.findall(r"DEFAULT_KEYS: KeyMap = \{(.*?)\n\};", source, re.DOTALL)
    assert frozenset(re.findall(r'"(\w+)"', table)) == DRIVING_KEYS | LATERAL_KEYS


@pytest.mark.parametrize(
    ("what", "name"),
    [("key", "KeyQ"), ("key", "KeyE"), ("pad_button", "LB"), ("pad_button", "RB")],
)
def test_what_moves_sideways_is_free_on_a_robot_that_cannot(what: str, name: str) -> None:
    """Q and E, LB and RB are refused only where the robot moves sideways by them."""
    text = LAMP + f'{what} = "{name}"\n[robot]\n'
    for base in ("", 'base = "mecanum"\nmax_lateral_mps = 0'):
        assert getattr(_parsed(text + base).controls[0], what) == name
    refused = (
        f"controls: lamp has the {what} {name}, which moves this robot sideways; give it another"
    )
    with pytest.raises(ConfigError, match=re.escape(refused)):
        _parsed(text + 'base = "mecanum"')


def test_the_manuals_examples_are_valid() -> None:
    """The manual's examples for the simulated robot are valid as they are."""
    manual = (ROOT / "config/wax.toml").read_text(encoding="utf-8")
    shown = re.findall(r"^#   ((?:controls|gauges) = \[)\n((?:#     .*\n)+)", manual, re.MULTILINE)
    text = "".join(begin + lines.replace("#     ", "") + "]\n" for begin, lines in shown)
    settings: dict[str, Any] = _parsed(text).model_dump()
    assert [one["name"] for one in settings["controls"]] == [
        "lamp",
        "horn",
        "brightness",
        "light",
        "look_around",
    ]
    assert [one["name"] for one in settings["gauges"]] == ["motor_c"]
