"""gpiozero's mock pins, in place of a Pi's."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import gpiozero
import pytest
from gpiozero.pins.mock import MockFactory, MockPWMPin

from wax.config.robot import RobotSettings

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

LEFT, RIGHT = (17, 27, 12), (23, 24, 13)
MECANUM: dict[str, Any] = {
    "front_left": [17, 27, 12],
    "front_right": [23, 24, 13],
    "back_left": [9, 10, 11],
    "back_right": [14, 15, 18],
}


def settings(robot: dict[str, Any] | None = None, **gpio: Any) -> RobotSettings:
    return RobotSettings.model_validate(
        {"driver": "gpio", "gpio": {"reopen_s": 0.05, "guard": False} | gpio} | (robot or {})
    )


class Board:
    """The pins as seen with a meter."""

    def __init__(self) -> None:
        self.factory = MockFactory(pin_class=MockPWMPin)

    def pin(self, number: int) -> Any:
        return self.factory.pin(number)

    def level(self, number: int) -> float:
        return float(self.pin(number).state)

    def motor(self, pins: Sequence[int]) -> float:
        """Return a motor's duty cycle, -1 to 1, on IN1, IN2, PWM."""
        ahead, back, speed = (self.level(pin) for pin in pins)
        assert ahead + back <= 1.0, "both directions at once"
        return (ahead - back) * speed

    def press(self, number: int) -> None:
        self.pin(number).drive_low()

    def release(self, number: int) -> None:
        self.pin(number).drive_high()

    def roll(self, pins: tuple[int, ...], steps: int) -> None:
        """Turn an encoder by `steps`: A leads forward, B backward."""
        if len(pins) == 1:
            for _ in range(steps):
                self.press(pins[0])
                self.release(pins[0])
            return
        first, second = pins if steps > 0 else pins[::-1]
        for _ in range(abs(steps)):
            self.press(first)
            self.press(second)
            self.release(first)
            self.release(second)


@pytest.fixture
def pins() -> Iterator[Board]:
    board = Board()
    before, gpiozero.Device.pin_factory = gpiozero.Device.pin_factory, board.factory
    yield board
    board.factory.reset()
    gpiozero.Device.pin_factory = before
