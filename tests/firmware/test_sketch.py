"""The sketch for the Arduino, compiled by the compiler that its owner's is."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import pytest
from tests.firmware.sketch import NO_SERVOS, built, changed

if TYPE_CHECKING:
    import subprocess
    from pathlib import Path

pytestmark = [pytest.mark.system, pytest.mark.timeout(300)]


def fits(done: subprocess.CompletedProcess[str]) -> None:
    assert done.returncode == 0, done.stderr
    sizes = json.loads(done.stdout)
    assert 4000 < sizes["flash_bytes"] < sizes["flash_bytes_of"] // 2
    assert 100 < sizes["ram_bytes"] < sizes["ram_bytes_of"] // 2


def test_the_sketch_fits_an_uno() -> None:
    """It compiles for the ATmega328P without a warning, in half of its memory at most."""
    fits(built())


def test_with_servos_and_a_battery_it_fits_as_well(tmp_path: Path) -> None:
    """Four servos on analog pins and a battery's voltage are no more than it can hold."""
    servos = NO_SERVOS.replace("NONE, NONE, NONE, NONE", "16, 17, 18, NONE")
    fits(changed(tmp_path, (NO_SERVOS, servos), ("BATTERY_PIN = NONE", "BATTERY_PIN = 19")))


def test_pins_that_servos_take_are_refused(tmp_path: Path) -> None:
    """A motor's PWM on a pin whose timer the servos need is an error that says so."""
    servos = NO_SERVOS.replace("NONE, NONE", "17, NONE", 1)
    done = changed(tmp_path, (NO_SERVOS, servos), ("LEFT_PWM = 5", "LEFT_PWM = 9"))
    assert done.returncode != 0
    assert "pins 9 and 10 have no PWM where servos are" in done.stderr
