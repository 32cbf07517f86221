"""A control of your own: a lamp on a Raspberry Pi's pin, beside the motors on others.

    [robot]
    driver = "lamp:WithLamp"
    gpio = { left = [17, 27, 12], right = [23, 24, 13] }

    [[controls]]
    name = "lamp"
    kind = "toggle"

Start the server with this folder in PYTHONPATH.
"""

from dataclasses import replace

import gpiozero

from wax.driver.interface import ControlValue, Limits
from wax.robot.gpio.driver import GpioRobot


class WithLamp(GpioRobot):
    newest_turn = 0

    @property
    def limits(self) -> Limits:
        return replace(super().limits, controls=("lamp",))

    def open(self) -> None:
        super().open()
        self.lamp = gpiozero.LED(21)

    def control(self, _: str, value: ControlValue, turn: int) -> None:
        if turn >= self.newest_turn:  # what is late from an earlier turn does nothing
            self.newest_turn = turn
            self.lamp.value = bool(value)

    def close(self) -> None:
        super().close()
        self.lamp.close()
