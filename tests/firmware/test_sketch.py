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


MECANUM = (
    ("BASE = wax::Kind::SIDES", "BASE = wax::Kind::MECANUM"),
    ("BACK_PWM = NONE, BACK_A = NONE, BACK_B = NONE", "BACK_PWM = 3, BACK_A = 16, BACK_B = 17"),
    (
        "BACK_RIGHT_PWM = NONE, BACK_RIGHT_A = NONE, BACK_RIGHT_B = NONE",
        "BACK_RIGHT_PWM = 11, BACK_RIGHT_A = 2, BACK_RIGHT_B = 4",
    ),
    ("LEFT_ENCODER_A = 2, LEFT_ENCODER_B = 4", "LEFT_ENCODER_A = NONE, LEFT_ENCODER_B = NONE"),
    ("RIGHT_ENCODER_A = 3, RIGHT_ENCODER_B = 11", "RIGHT_ENCODER_A = NONE, RIGHT_ENCODER_B = NONE"),
)


def test_four_mecanum_wheels_fit_as_well(tmp_path: Path) -> None:
    """With the pins that config.h names, in place of the encoders."""
    fits(changed(tmp_path, *MECANUM))


def test_a_base_without_the_pins_of_its_wheels_is_refused(tmp_path: Path) -> None:
    """A wheel that never turns would pull the robot to the side."""
    done = changed(tmp_path, *MECANUM[:2], *MECANUM[3:])
    assert done.returncode != 0
    assert "four mecanum wheels need the pins of the fourth" in done.stderr


@pytest.mark.parametrize(("encoder", "name"), [(3, "LEFT"), (4, "RIGHT")])
def test_motors_on_pins_of_an_encoder_are_refused(tmp_path: Path, encoder: int, name: str) -> None:
    """An input that drives a motor is an error that says so, whichever encoder's it is."""
    done = changed(tmp_path, *MECANUM[:encoder], *MECANUM[encoder + 1 :])
    assert done.returncode != 0, name
    assert "a motor's pin is an encoder's too" in done.stderr


def test_pins_that_servos_take_are_refused(tmp_path: Path) -> None:
    """A motor's PWM on a pin whose timer the servos need is an error that says so."""
    servos = NO_SERVOS.replace("NONE, NONE", "17, NONE", 1)
    done = changed(tmp_path, (NO_SERVOS, servos), ("LEFT_PWM = 5", "LEFT_PWM = 9"))
    assert done.returncode != 0
    assert "pins 9 and 10 have no PWM where servos are" in done.stderr
