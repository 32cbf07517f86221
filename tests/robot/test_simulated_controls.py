"""What the simulated robot has besides wheels, such as a lamp and a horn."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np
import pytest

from wax.clock import SystemClock
from wax.config.local import LocalSettings
from wax.config.robot import RobotSettings
from wax.config.video import VideoSettings
from wax.driver.interface import STANDSTILL, HasControls, Pose, Twist
from wax.robot.find_driver import make_robot
from wax.robot.simulated.chair import SimulatedChair
from wax.robot.simulated.flat import furnished_flat
from wax.robot.simulated.hearing import BLOCK_S, HORN_HZ, SoundMixer
from wax.robot.simulated.lamp import Lamp, lit
from wax.robot.simulated.robot import SimulatedRobot
from wax.robot.simulated.simulation import CONTROLS, LOOK_AROUND_RPS, ROOM_C, Senses, Simulation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from wax.driver.interface import ControlValue

WORLD: Final = furnished_flat()


class Ride:
    """A simulation that gets a set-point 50 times a second, until the server is silent."""

    def __init__(self) -> None:
        self.simulation = Simulation(RobotSettings(), WORLD)
        self.now_s = 100.0
        self.simulation.start(self.now_s)
        self.twist = STANDSTILL

    def go_on(self, seconds: float, *, is_silent: bool = False) -> Senses:
        for _ in range(round(seconds * 50)):
            self.now_s += 0.02
            if not is_silent:
                self.simulation.apply(self.twist, 1, self.now_s)
            self.simulation.advance(self.now_s)
        return self.simulation.senses

    def turned(self, seconds: float, *, is_silent: bool = False) -> float:
        before = self.simulation.senses.pose.heading_rad
        return self.go_on(seconds, is_silent=is_silent).pose.heading_rad - before


@pytest.mark.parametrize(
    ("name", "value", "lamp"),
    [
        ("lamp", True, Lamp(is_on=True)),
        ("lamp", False, Lamp()),
        ("brightness", 40.0, Lamp(brightness=40.0)),
        ("brightness", 400.0, Lamp(brightness=100.0)),
        ("brightness", -1.0, Lamp(brightness=0.0)),
        ("light", "red", Lamp(light="red")),
        ("light", "plaid", Lamp()),
        ("brightness", "red", Lamp()),
        ("siren", True, Lamp()),
    ],
)
def test_its_lamp(name: str, value: ControlValue, lamp: Lamp) -> None:
    """Only valid values are accepted, and a stop does not change them."""
    ride = Ride()
    ride.simulation.control(name, value, 1)
    ride.simulation.stop(1)
    assert ride.go_on(0.1).lamp == lamp
    ride.simulation.control("lamp", not lamp.is_on, 0)  # an earlier turn's
    assert ride.go_on(0.1).lamp == lamp


def test_it_looks_around_while_that_is_held() -> None:
    """It turns on the spot until it is released, a stop comes or the server is silent."""
    ride = Ride()
    ride.simulation.control("look_around", True, 1)
    assert ride.turned(1.0) == pytest.approx(LOOK_AROUND_RPS, rel=0.2)
    ride.simulation.control("look_around", False, 1)
    ride.go_on(0.3)
    assert ride.turned(0.5) == 0.0
    ride.simulation.control("look_around", True, 1)
    ride.simulation.stop(1)
    assert ride.turned(0.5) == 0.0
    ride.simulation.control("look_around", True, 1)
    ride.go_on(0.3)
    ride.go_on(1.0, is_silent=True)
    assert ride.turned(0.5) == 0.0  # not even when the server is back


def test_the_horn_ends_when_the_server_is_silent() -> None:
    """The watchdog releases held controls, and leaves the lamp on."""
    ride = Ride()
    ride.simulation.control("horn", True, 1)
    ride.simulation.control("lamp", True, 1)
    assert ride.go_on(0.5).is_honking
    senses = ride.go_on(0.5, is_silent=True)
    assert not senses.is_honking
    assert senses.lamp.is_on


def test_its_motors_warm_up_and_cool_down() -> None:
    """Driving warms the motors, and standing cools them towards room temperature."""
    ride = Ride()
    ride.twist = Twist(0.0, 1.5)
    assert ride.go_on(0.1).motor_c == pytest.approx(ROOM_C, abs=0.1)
    warm_c = ride.go_on(120.0).motor_c
    assert 30.0 < warm_c < 60.0
    ride.twist = STANDSTILL
    assert ROOM_C < ride.go_on(60.0).motor_c < warm_c - 3.0


def _mean(image: NDArray[np.uint8]) -> tuple[float, float, float]:
    blue, green, red = image.reshape(-1, 3).mean(axis=0)
    return float(blue), float(green), float(red)


def test_its_lamp_is_seen() -> None:
    """The lamp brightens the picture, most in the middle, and in its colour."""
    grey = np.full((120, 160, 3), 80, np.uint8)
    assert lit(grey, Lamp(brightness=100.0)) is grey
    white = lit(grey, Lamp(is_on=True))
    assert min(_mean(white)) > 90
    assert white[55, 80].max() > white[0, 0].max() >= 80
    dim = lit(grey, Lamp(is_on=True, brightness=20.0))
    assert 80 < min(_mean(dim)) < min(_mean(white))
    blue, _, red = _mean(lit(grey, Lamp(is_on=True, light="red")))
    assert red > blue + 10
    assert lit(np.full_like(grey, 250), Lamp(is_on=True)).max() == 255


def test_its_horn_is_heard() -> None:
    """Both notes sound, and begin and end without a click."""
    senses = Senses(0.0, Pose(9.0, 8.0, 0.0))
    mixer = SoundMixer(WORLD)

    def hear(blocks: int, *, is_honking: bool) -> NDArray[np.float64]:
        moments = (replace(senses, at_s=n * BLOCK_S, is_honking=is_honking) for n in range(blocks))
        return np.concatenate([mixer.block(one)[:, 0] for one in moments]) / 32768.0

    quiet = hear(50, is_honking=False)
    loud = hear(100, is_honking=True)
    after = hear(50, is_honking=False)
    assert np.std(loud) > 5 * np.std(quiet)
    assert np.std(after[BLOCK_SAMPLES_END:]) < 2 * np.std(quiet)
    spectrum = np.abs(np.fft.rfft(loud * np.hanning(len(loud))))
    for hz in HORN_HZ:
        near = spectrum[round(hz) - 3 : round(hz) + 4].max()
        assert near > 20 * np.median(spectrum)
    steps = np.abs(np.diff(np.concatenate([quiet, loud, after])))
    assert steps.max() < 0.06


BLOCK_SAMPLES_END = 480
"""The first block after the horn still fades."""


def test_the_robot_shows_and_reports_them() -> None:
    """The lamp brightens its picture, and its state has the motors' temperature."""
    robot = SimulatedRobot(RobotSettings(), SystemClock())
    assert isinstance(robot, HasControls)
    assert robot.limits.controls == CONTROLS
    assert robot.state().gauges == {"motor_c": ROOM_C}
    settings = VideoSettings(width=160, height=120, fps=60.0)
    eye = robot.camera(settings, SystemClock())
    eye.open()
    dark = eye.read().i420[:120].mean()
    robot.control("lamp", True, 0)
    bright = eye.read().i420[:120].mean()
    eye.close()
    assert bright > dark + 10


def test_its_controls_work_with_somebody_aboard() -> None:
    """The chair has the robot's own controls, by the rules of a driver process."""
    robot = make_robot(RobotSettings(), SystemClock(), local=LocalSettings(source="robot"))
    assert isinstance(robot, SimulatedChair)
    assert isinstance(robot, HasControls)
    robot.control("lamp", True, 1)  # ignored, as it is not configured
    assert not robot._robot.senses().lamp.is_on
