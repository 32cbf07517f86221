"""The driver for pins on gpiozero's mock pins, which are metered; an ordinary plug-in.

The environment names the meter's file. Each line is a pin that has changed: when by
``time.monotonic``, its number, and its state from 0 to 1.
"""

from __future__ import annotations

import os
import time
from typing import Any, Final

import gpiozero
from gpiozero.pins.mock import MockFactory, MockPWMPin

from wax.robot.gpio.driver import GpioRobot

METER: Final = "WAX_DRIVERS_METER"


class MeteredPin(MockPWMPin):  # type: ignore[misc]  # gpiozero has no types
    """Records each change, in one write."""

    file = -1

    def _change_state(self, value: float) -> Any:
        changed = super()._change_state(value)
        if changed and self.file >= 0:
            line = f"{time.monotonic():.6f} {self.info.name.removeprefix('GPIO')} {float(value)}\n"
            os.write(self.file, line.encode())
        return changed


class MeteredRobot(GpioRobot):
    """The driver, unchanged."""

    def open(self) -> None:
        MeteredPin.file = os.open(os.environ[METER], os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)
        gpiozero.Device.pin_factory = MockFactory(pin_class=MeteredPin)
        super().open()
