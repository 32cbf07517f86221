"""The sketch as it is flashed, in an emulator of the chip, driven by the real driver."""

from __future__ import annotations

import subprocess
import time
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from tests.firmware.core import ROOT, power
from tests.firmware.sketch import IS_WANTED, NO_SERVOS, changed
from tests.robot.board_process import BoardProcess

from wax.clock import SystemClock
from wax.config.robot import RobotSettings
from wax.driver.interface import STANDSTILL, Twist
from wax.robot.serial.driver import SerialRobot

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from wax.driver.interface import RobotState

pytestmark = [pytest.mark.system, pytest.mark.full, pytest.mark.timeout(120)]

AHEAD = Twist(0.4, 0.0)
HALF = power(400, full_mmps=800, least=40)
SERVO_ERROR_US = 15
"""As `port.h` promises, like the next two."""
WATCHDOG_MOST_MS = 250
TICKS_PER_S = 5000


@pytest.fixture(scope="module")
def elf(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the sketch with a servo on A2 and the battery at A5."""
    if not Path("/usr/include/simavr/sim_avr.h").exists() and not IS_WANTED:
        pytest.skip("there is no emulator of the Arduino: sh .make/firmware.sh emulator")
    folder = tmp_path_factory.mktemp("uno")
    servos = NO_SERVOS.replace("NONE, NONE", "16, NONE", 1)
    done = changed(folder, (NO_SERVOS, servos), ("BATTERY_PIN = NONE", "BATTERY_PIN = 19"))
    assert done.returncode == 0, done.stderr
    return folder / "built" / "wax.elf"


class Uno(BoardProcess):
    """The emulated board, and the driver at its port."""

    patience_s = 20.0

    def __init__(self, elf: Path, folder: Path) -> None:
        built = subprocess.run(
            ["sh", ".make/firmware.sh", "emulator"],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=False,
        )
        assert built.returncode == 0, built.stderr
        super().__init__([built.stdout.splitlines()[-1], str(elf)], folder)
        self.wait_until(lambda: self.all("plug") != [])
        serial = {"url": str(self.port), "axes": ["pan"], "reopen_s": 0.05}
        settings = {"driver": "serial", "serial": serial | {"ticks_per_m": 1000.0}}
        self.driver = SerialRobot(RobotSettings.model_validate(settings), SystemClock())
        self.driver.open()
        self.wait_until(lambda: self.state.connected)

    @property
    def state(self) -> RobotState:
        return self.driver.state()

    @property
    def motors(self) -> tuple[int, int]:
        return self.newest("motors")

    def drive(self, twist: Twist, until: Callable[[], bool], turn: int = 1) -> None:
        """Stand, then drive until `until`; after a lost connection stand first, as people must."""
        epoch = 0

        def so() -> bool:
            nonlocal epoch
            before, epoch = epoch, self.state.epoch
            self.driver.apply(twist if epoch == before else STANDSTILL, turn)
            return until()

        self.wait_until(so)


@pytest.fixture
def uno(elf: Path, tmp_path: Path) -> Iterator[Uno]:
    uno = Uno(elf, tmp_path)
    yield uno
    uno.end()


@pytest.mark.parametrize(
    ("twist", "motors"),
    [
        (AHEAD, (HALF, HALF)),
        (Twist(-0.4, 0.0), (-HALF, -HALF)),
        (Twist(0.0, 1.0), (-power(150, 800, 40), power(150, 800, 40))),
    ],
)
def test_the_motors_get_what_the_server_says(
    uno: Uno, twist: Twist, motors: tuple[int, int]
) -> None:
    """The chip's pins have the power and direction of the wheels' speeds; a stop ends them."""
    assert uno.motors == (0, 0)
    uno.drive(twist, lambda: uno.motors == motors)
    uno.drive(twist, lambda: uno.state.moving is True)
    uno.driver.stop(1)
    uno.wait_until(lambda: uno.motors == (0, 0))
    uno.wait_until(lambda: uno.state.moving is False)


def test_a_servo_gets_its_pulses(uno: Uno) -> None:
    """There are none before its axis has a position; then they have its width, every 20 ms."""
    time.sleep(0.2)
    assert uno.all("pulse") == []
    uno.driver.apply(STANDSTILL, 1)
    uno.driver.set_axis("pan", 0.5, 1)
    uno.drive(AHEAD, lambda: len(uno.all("pulse")) > 60)
    pulses = uno.all("pulse")
    assert {pulse["us"] for pulse in pulses} <= set(range(1750 - SERVO_ERROR_US, 1766))
    assert all(19_500 < pulse["apart_us"] < 20_500 for pulse in pulses[1:])
    uno.driver.set_axis("pan", -1.0, 1)
    uno.wait_until(lambda: abs(uno.all("pulse")[-1]["us"] - 1000) <= SERVO_ERROR_US)
    widths = [pulse["us"] for pulse in uno.all("pulse")[len(pulses) :]]
    assert max(widths) - min(widths) > 500, "it went there in one step"


def test_what_it_feels_is_told(uno: Uno) -> None:
    """Ticks at the promised rate, none lost; the battery's voltage; where it is by its wheels."""
    uno.write("battery 2500")
    uno.write(f"turn 5000 -3000 {TICKS_PER_S}")
    uno.wait_until(lambda: uno.state.extra["left_ticks"] == 5000.0)
    time.sleep(0.2)
    assert (uno.state.extra["left_ticks"], uno.state.extra["right_ticks"]) == (5000.0, -3000.0)
    uno.wait_until(lambda: abs((uno.state.battery_v or 0.0) - 7.5) < 0.05)
    assert uno.state.pose is not None
    assert abs(uno.state.pose.heading_rad) <= 3.15


def test_a_pressed_bumper_stops_it(uno: Uno) -> None:
    """The front bumper, on pin 12, stops it there, but lets it go back."""
    uno.drive(AHEAD, lambda: uno.motors == (HALF, HALF))
    uno.write("press 4")
    uno.drive(AHEAD, lambda: uno.motors == (0, 0) and uno.state.bumpers == 1)
    uno.drive(Twist(-0.4, 0.0), lambda: uno.motors == (-HALF, -HALF))
    uno.write("release 4")
    uno.drive(AHEAD, lambda: uno.motors == (HALF, HALF))


def test_a_pulled_cable_stops_it(uno: Uno) -> None:
    """Its own clock stops it; plugged in again it stands until it is driven anew."""
    uno.drive(AHEAD, lambda: uno.motors == (HALF, HALF))
    uno.write("unplug")
    uno.wait_until(lambda: uno.motors == (0, 0))
    turned = len(uno.all("motors"))
    uno.write("plug")
    uno.wait_until(lambda: uno.state.connected and uno.state.epoch > 1)
    for _ in range(30):
        uno.driver.apply(AHEAD, 1)
        time.sleep(0.01)
    assert len(uno.all("motors")) == turned
    uno.drive(AHEAD, lambda: uno.motors == (HALF, HALF), turn=2)


def test_a_program_that_hangs_is_restarted(uno: Uno) -> None:
    """The chip's watchdog restarts it, with the motors off; it stands until it is driven anew."""
    uno.drive(AHEAD, lambda: uno.motors == (HALF, HALF))
    epoch = uno.state.epoch
    uno.write("hang")
    uno.drive(AHEAD, lambda: uno.all("restart") != [])
    assert uno.all("restart")[0]["after_ms"] <= WATCHDOG_MOST_MS
    uno.wait_until(lambda: uno.motors == (0, 0))
    turned = len(uno.all("motors"))
    uno.wait_until(lambda: uno.state.connected and uno.state.epoch > epoch)
    for _ in range(30):
        uno.driver.apply(AHEAD, 1)
        time.sleep(0.01)
    assert len(uno.all("motors")) == turned
