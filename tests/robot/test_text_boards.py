"""The examples in `config/` drive their boards, which are programs in other processes."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from tests.robot.board_process import BoardProcess

from wax.clock import SystemClock
from wax.config import settings as config
from wax.config.robot import RobotSettings
from wax.driver.interface import STANDSTILL, Twist
from wax.robot.serial.driver import SerialRobot

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from wax.driver.interface import RobotState

pytestmark = pytest.mark.system

CONFIG = Path(__file__).parents[2] / "config"
FILES = {"bridge": "ros-arduino-bridge.toml", "roboteq": "roboteq.toml", "mute": "roboteq.toml"}
AHEAD = Twist(0.3, 0.0)


class Sketch(BoardProcess):
    """A board of this kind, and a driver at its port with the example's settings."""

    def __init__(self, kind: str, folder: Path, **text: Any) -> None:
        super().__init__([sys.executable, str(Path(__file__).with_name("sketch.py")), kind], folder)
        self.wait_until(lambda: self.all("plugged") != [], "it is plugged in")
        robot = config.load(CONFIG / FILES[kind]).robot.model_dump()
        # The longest time-to-live, so that a busy machine does not count as silence.
        robot["serial"] |= {"url": str(self.port), "reopen_s": 0.05, "ttl_ms": 1000}
        robot["serial"]["text"] |= text
        self.settings = RobotSettings.model_validate(robot)
        self.driver = SerialRobot(self.settings, SystemClock())

    def do(self, command: str) -> float:
        """Send the board's process a command; return when it was done."""
        before = len(self.all(command))
        self.write(command)
        self.wait_until(lambda: len(self.all(command)) > before, command)
        return float(self.all(command)[-1]["t_s"])

    @property
    def wheels(self) -> tuple[int, int]:
        return self.newest("wheels")

    def until(self, so: Callable[[RobotState], bool]) -> RobotState:
        self.wait_until(lambda: so(self.driver.state()), "the state is so")
        return self.driver.state()

    def drive(self, twist: Twist = AHEAD, turn: int = 1) -> None:
        """Stand, then drive until the wheels turn."""
        self.until(lambda state: state.connected)
        self.driver.apply(STANDSTILL, turn)
        self.keep(twist, turn, lambda: self.wheels != (0, 0))

    def keep(self, twist: Twist, turn: int, until: Callable[[], bool]) -> None:
        def so() -> bool:
            self.driver.apply(twist, turn)
            return until()

        self.wait_until(so, "it is so while driven")


@pytest.fixture(params=["bridge", "roboteq"])
def sketch(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Sketch]:
    sketch = Sketch(request.param, tmp_path)
    sketch.driver.open()
    yield sketch
    sketch.end()


@pytest.mark.alone
def test_it_drives_reports_and_stops(sketch: Sketch) -> None:
    """The wheels turn at the commanded speed, the board's values are read, and it stops."""
    sketch.drive()
    text = sketch.settings.serial.text
    share = round(AHEAD.linear_mps * text.per_mps)
    sketch.keep(AHEAD, 1, lambda: sketch.wheels == (share, share))
    sketch.keep(AHEAD, 1, lambda: sketch.driver.state().moving is True)
    stopped_s = time.monotonic()
    sketch.driver.stop(1)
    state = sketch.until(lambda _: sketch.wheels == (0, 0))
    assert sketch.all("wheels")[-1]["t_s"] - stopped_s < 0.2
    sketch.until(lambda state: state.moving is False)
    if sketch.settings.serial.ticks_per_m:
        assert state.pose is not None
        assert state.pose.x_m > 0.0
    else:
        assert state.battery_v == 24.6


def test_it_curves_as_commanded(sketch: Sketch) -> None:
    """To the left, the right wheel is faster, by the wheel base."""
    robot = sketch.settings
    sketch.drive(Twist(0.0, 1.0))
    aside = round(robot.wheel_base_m / 2 * robot.serial.text.per_mps)
    sketch.keep(Twist(0.0, 1.0), 1, lambda: sketch.wheels == (-aside, aside))


def test_a_pulled_cable_stops_it_in_its_own_time(sketch: Sketch) -> None:
    """Its watchdog of `ttl_ms` stops the board; plugged in, it stands until driven again."""
    sketch.drive()
    epoch = sketch.driver.state().epoch
    out_s = sketch.do("unplug")
    sketch.wait_until(lambda: sketch.wheels == (0, 0), "its watchdog has stopped it")
    turned = sketch.all("wheels", out_s)
    assert turned[-1]["why"] in ("auto stop", "watchdog")
    assert turned[-1]["after_s"] <= sketch.settings.serial.text.ttl_ms / 1000.0
    back_s = sketch.do("plug")
    assert sketch.until(lambda state: state.connected and state.epoch > epoch).connected
    for _ in range(20):
        sketch.driver.apply(AHEAD, 1)
        time.sleep(0.01)
    assert sketch.all("wheels", back_s) == []
    sketch.drive(turn=2)


def test_a_board_that_restarts_stands_until_driven_again(sketch: Sketch) -> None:
    """A booting board does not answer: the connection starts over, with its settings."""
    sketch.drive()
    epoch = sketch.driver.state().epoch
    reset_s = sketch.do("reset")
    sketch.keep(AHEAD, 1, lambda: sketch.driver.state().epoch > epoch)
    for _ in range(20):
        sketch.driver.apply(AHEAD, 1)
        time.sleep(0.01)
    assert [one for one in sketch.all("wheels", reset_s) if one["why"] != "reset"] == []


def test_a_board_that_hangs_is_a_problem(sketch: Sketch) -> None:
    """The problem says what to do, until the board answers again."""
    sketch.until(lambda state: state.connected)
    sketch.do("freeze")
    problem = sketch.until(lambda state: not state.connected).problem
    assert "says nothing on" in str(problem)
    sketch.do("thaw")
    sketch.until(lambda state: state.connected)


def test_the_last_line_is_a_stop(sketch: Sketch) -> None:
    """After closing in motion the wheels stop at once, by command."""
    sketch.drive()
    sketch.driver.close()
    sketch.wait_until(lambda: sketch.wheels == (0, 0), "it stands")
    assert sketch.all("wheels")[-1]["why"] in ("told", "emergency stop")


def test_the_controller_is_set_before_it_is_driven(tmp_path: Path) -> None:
    """Its watchdog is on and its echo off before the first motion, and it ends stopped."""
    sketch = Sketch("roboteq", tmp_path)
    sketch.driver.open()
    sketch.drive()
    sketch.driver.close()
    sketch.wait_until(lambda: sketch.all("command")[-1]["line"] == "!EX", "the last line has come")
    sketch.end()
    lines = [one["line"] for one in sketch.all("command")]
    motions = [n for n, line in enumerate(lines) if line[:3] == "!M " and line != "!M 0 0"]
    begin = lines.index("^ECHOF 1")
    assert lines[begin : begin + 4] == ["^ECHOF 1", "^RWD 250", "!MG", "!M 0 0"]
    assert begin < motions[0]
    assert lines[0] == "!M 0 0"


@pytest.mark.parametrize(
    ("kind", "text", "said"),
    [
        ("mute", {}, "says nothing on"),
        ("bridge", {"drive": "M {left} {right}\r"}, "says “Invalid Command”"),
    ],
)
def test_a_sketch_that_does_not_answer_stands(
    tmp_path: Path, kind: str, text: dict[str, Any], said: str
) -> None:
    """Without the right answer there is a problem, and nothing moves the board."""
    sketch = Sketch(kind, tmp_path, boot_ms=100, **text)
    sketch.driver.open()
    try:
        problem = sketch.until(lambda state: state.problem is not None).problem
        assert said in str(problem)
        assert "[robot.serial.text]" in str(problem)
        for _ in range(50):
            sketch.driver.apply(STANDSTILL, 1)
            sketch.driver.apply(AHEAD, 1)
            time.sleep(0.01)
        assert sketch.all("wheels") == []
        assert not sketch.driver.state().connected
    finally:
        sketch.end()
