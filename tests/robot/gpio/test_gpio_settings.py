"""A wrong table of pins is reported when the configuration is loaded."""

from __future__ import annotations

from typing import Any

import pytest
from tests.robot.gpio.conftest import MECANUM, settings

from wax.clock import SystemClock
from wax.config.settings import parse
from wax.errors import ConfigError
from wax.robot.find_driver import make_driver
from wax.robot.gpio.settings import BOARDS, PINS_OF, GpioSettings


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        ({"left": [1, 2]}, "left has 2 pins; a motor on in_in_pwm has 3"),
        ({"bridge": "in_in"}, "left has 3 pins; a motor on in_in has 2"),
        ({"servos": {"pan": 17}}, "pin 17 is used twice, for left and servos"),
        ({"board": "camjam", "front_bumpers": [9]}, "pin 9 is used twice"),
        ({"left_encoder": [5]}, "right_encoder is missing; all wheels have an encoder, or none"),
        ({"front_left": [5, 6, 7]}, "front_right has 0 pins; a motor on in_in_pwm has 3"),
        ({"back": [5, 6]}, "back has 2 pins; a motor on in_in_pwm has 3"),
        ({"back": [17, 5, 6]}, "pin 17 is used twice, for left and back"),
        ({"left_encoder": [5], "right_encoder": [17]}, "used twice, for left and right_encoder"),
        ({"back": [5, 6, 7], "left_encoder": [8], "right_encoder": [9]}, "back_encoder is missing"),
        ({"back_encoder": [5]}, "back_encoder is no wheel beside left and right; leave it out"),
        (MECANUM | {"left": [8, 9, 10]}, "left is no wheel beside front_left and front_right and"),
        ({"board": "camjam", "back": [5, 6, 11]}, 'board "camjam" has two motors; for more'),
        ({"left": [17, 27, 40]}, "robot.gpio.left"),
        ({"servos": {"pan": "18"}}, "robot.gpio.servos"),
        ({"board": "camjan"}, "robot.gpio.board"),
    ],
)
def test_a_wrong_table_is_one_sentence(table: dict[str, Any], sentence: str) -> None:
    """The error names the key or pin."""
    with pytest.raises(ConfigError) as raised:
        parse({"robot": {"driver": "gpio", "gpio": table}}, "wax.toml")
    assert sentence in str(raised.value)


@pytest.mark.parametrize("board", BOARDS)
def test_known_boards_fit_their_bridge(board: str) -> None:
    """Each board has as many pins as its bridge, none twice."""
    bridge, motors = settings(board=board).own(GpioSettings).motors
    left, right = motors.values()
    assert len(left) == len(right) == PINS_OF[bridge]
    assert len({*left, *right}) == len(left) + len(right)


def test_the_pins_of_a_base_are_those_of_its_motors() -> None:
    """Four motors take the place of two, whose default pins are then free."""
    own = settings(**MECANUM).own(GpioSettings)
    assert (own.base, list(own.motors[1])) == ("mecanum", list(MECANUM))


@pytest.mark.parametrize(
    ("base", "pins", "sentence"),
    [
        ("mecanum", {}, 'is "mecanum", but [robot.gpio] has the pins of left, right; set'),
        ("differential", MECANUM, 'set it to "mecanum", or give those of left, right'),
        ("omni", {}, 'set it to "differential", or give those of left, right, back'),
    ],
)
def test_pins_of_another_base_are_refused(base: str, pins: dict[str, Any], sentence: str) -> None:
    """The sentence names both, the base and the wheels whose pins are given, and either way out."""
    with pytest.raises(ConfigError) as raised:
        make_driver(settings({"base": base}, **pins), SystemClock())
    assert str(raised.value).startswith("robot.base: ")
    assert sentence in str(raised.value)


def test_two_motors_cannot_move_it_sideways() -> None:
    """A speed sideways is refused for a base without the wheels for it."""
    with pytest.raises(ConfigError, match=r"^robot\.max_lateral_mps: gpio cannot"):
        make_driver(settings({"max_lateral_mps": 0.3}), SystemClock())
