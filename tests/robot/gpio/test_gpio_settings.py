"""A wrong table of pins is reported when the configuration is loaded."""

from __future__ import annotations

from typing import Any

import pytest
from tests.robot.gpio.conftest import settings

from wax.config.settings import parse
from wax.errors import ConfigError
from wax.robot.gpio.settings import BOARDS, PINS_OF, GpioSettings


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        ({"left": [1, 2]}, "left has 2 pins; a motor on in_in_pwm has 3"),
        ({"bridge": "in_in"}, "left has 3 pins; a motor on in_in has 2"),
        ({"servos": {"pan": 17}}, "pin 17 is used twice, for left and servos"),
        ({"board": "camjam", "front_bumpers": [9]}, "pin 9 is used twice"),
        ({"left_encoder": [5]}, "left_encoder and right_encoder belong together"),
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
    bridge, left, right = settings(board=board).own(GpioSettings).motors
    assert len(left) == len(right) == PINS_OF[bridge]
    assert len({*left, *right}) == len(left) + len(right)
