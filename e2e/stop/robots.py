"""The robots at the other end of the drivers, each with a record of what came over its wire."""

from __future__ import annotations

import asyncio
import math
import shutil
import sys
import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from tests.free_port import free_port
from tests.robot.mavlink.counterpart import Rover, as_twist, wall_s
from tests.robot.ros2.base import Base, own_domain
from tests.robot.ros2.bridge import Bridge

from e2e.harness.board import Board
from e2e.measure.suite import ROOT
from e2e.stop.mock_pins import METER
from e2e.stop.record import Record
from e2e.stop.stage import Robot, behind_a_cable, firmware

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from wax.driver.interface import Twist

_HALF_BASE_M: Final = 0.15
_SKETCH: Final = ROOT / "tests/robot/sketch.py"
_MOTORS: Final = (12, 13)
"""The pins of the left and the right motor in `[robot.gpio]` by default."""


def _frame(at_s: float, left: float, right: float) -> Iterator[dict[str, Any]]:
    """Write a set-point as in the board's log, and the wheels' motion, which follows it at once."""
    speeds = {"left": round(left * 1000), "right": round(right * 1000)}
    yield {"t_s": at_s, "event": "frame", "type": "drive", "verdict": "taken", "turn": 0} | speeds
    yield {"t_s": at_s, "event": "wheels"} | speeds


def _twist(at_s: float, twist: Twist) -> Iterator[dict[str, Any]]:
    turn_mps = twist.angular_rps * _HALF_BASE_M
    yield from _frame(at_s, twist.linear_mps - turn_mps, twist.linear_mps + turn_mps)


class Heard(Record):
    """A record that is no file: `news` returns what is new, as a board's events."""

    def __init__(self, news: Callable[[], Iterable[dict[str, Any]]]) -> None:
        super().__init__(Path())
        self._news = news

    def read(self) -> None:
        self.take(self._news())


class SketchRecord(Record):
    """The log of a board with ros_arduino_bridge."""

    def take(self, events: Iterable[dict[str, Any]]) -> None:
        super().take(one for event in events for one in _of_sketch(event))


def _of_sketch(event: dict[str, Any]) -> Iterator[dict[str, Any]]:
    if event["event"] == "command" and event["letter"] == "m":
        yield from _frame(event["t_s"], event["first"] / 1000, event["second"] / 1000)
    elif event["event"] == "wheels" and event["why"] == "auto stop":
        yield {"t_s": event["t_s"], "event": "ttl"}
        yield event


class PinRecord(Record):
    """A motor keeps its duty cycle, so nothing is written until it changes."""

    lasts_s = math.inf

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        path.touch()  # the driver creates it when a pin changes
        self._open = dict.fromkeys(_MOTORS, 0.0)

    def read(self) -> None:
        for line in self.lines():
            at_s, pin, state = line.decode().split()
            if int(pin) in self._open:
                self._open[int(pin)] = float(state)
                self.take(_frame(float(at_s), *self._open.values()))


class SketchBoard(Board):
    """ros_arduino_bridge behind a pseudo-terminal, described by lines as a host would."""

    @property
    def robot(self) -> dict[str, Any]:
        text = {
            "drive": "m {left} {right}\r",
            "per_mps": 133.3,
            "ttl_ms": 2000,
            "answers": "OK",
            "boot_ms": 0,
        }
        serial = {"url": str(self.path), "baud": 57_600, "dialect": "text", "text": text}
        return {"driver": "serial", "serial": serial}

    async def unplug(self) -> float:
        return await self._do("unplug", "unplug")

    async def plug(self) -> float:
        return await self._do("plug", "plug")

    async def _program(self) -> list[str]:
        return [sys.executable, str(_SKETCH), "bridge", str(self.path), str(self.log_path)]


def _sketch(folder: Path) -> Robot:
    board = SketchBoard(folder)
    return behind_a_cable(board, SketchRecord(board.log_path))


def _ros(base: Base | Bridge, **ros2: Any) -> Robot:
    """Make a ROS 2 base, reached in one of three ways; it starts and ends often."""

    def news() -> Iterator[dict[str, Any]]:
        for told in base.forget():
            yield from _twist(told.at_s, told.twist)

    start, end = (partial(asyncio.to_thread, act) for act in (base.start, base.end))
    return Robot(Heard(news), {"driver": "ros2", "ros2": ros2}, start, end, cut=end, mend=start)


def _dds(_folder: Path, *, fast: bool) -> Robot:
    domain = own_domain()
    return _ros(Base(domain, fast=fast), domain=domain, interface="127.0.0.1")


def _rosbridge(_folder: Path) -> Robot:
    """Make the tests' rosbridge server: no other one can be installed here."""
    bridge = Bridge()
    bridge.port = free_port()
    return _ros(bridge, transport="rosbridge", rosbridge_url=bridge.url)


class _Rover:
    """A rover by another MAVLink library, armed and in GUIDED.

    Its ground-station failsafe waits 600 s: after it stops the rover, somebody must restart it by
    hand.
    """

    def __init__(self) -> None:
        self.port = free_port()
        self._rover: Rover | None = None
        self._ahead_s = 0.0

    async def start(self) -> None:
        self._ahead_s = wall_s() - time.monotonic()
        self._rover = await asyncio.to_thread(
            Rover, f"udpout:127.0.0.1:{self.port}", mode="guided", armed=True, FS_GCS_TIMEOUT=600.0
        )

    def news(self) -> Iterator[dict[str, Any]]:
        assert self._rover is not None
        for event in self._rover.new_events():
            at_s = event["t"] - self._ahead_s
            twist = as_twist(event)
            if twist is not None:
                yield from _twist(at_s, twist)
            elif event["event"] == "moves" and event["why"] not in ("velocity", "manual"):
                yield {"t_s": at_s, "event": "ttl"}
                yield {"t_s": at_s, "event": "wheels", "left": 0, "right": 0}

    async def tell(self, *words: str) -> None:
        assert self._rover is not None
        self._rover.command(*words)

    async def stop(self) -> None:
        rover, self._rover = self._rover, None
        if rover is not None:
            await asyncio.to_thread(rover.close)


def _mavlink(_folder: Path) -> Robot:
    rover = _Rover()
    link = {"url": f"udpin:127.0.0.1:{rover.port}"}
    cut, mend = partial(rover.tell, "mute", "deaf"), partial(rover.tell, "hear")
    settings = {"driver": "mavlink", "mavlink": link}
    return Robot(Heard(rover.news), settings, rover.start, rover.stop, cut, mend)


def _pins(folder: Path) -> Robot:
    """Make two motors on gpiozero's mock pins, which are in the driver's process."""
    meter = folder / "pins.log"
    settings = {"driver": "e2e.stop.mock_pins:MeteredRobot", "gpio": {"guard": False}}
    return Robot(PinRecord(meter), settings, environment={METER: str(meter)})


@dataclass(frozen=True, slots=True)
class Kind:
    """A driver, and how its robot stops when the driver's process is gone.

    The robot stops by its own timeout of `time_out_ms`, or because a standby tells it to; where
    both are missing, the pins are cleared with the process. Only `is_linked` kinds have a link that
    can be cut. Its operator holds `way`: ahead, turning and sideways, as shares of the limits.
    """

    key: str
    what: str
    robot: Callable[[Path], Robot]
    time_out_ms: float | None = None
    has_standby: bool = False
    is_linked: bool = True
    way: tuple[float, ...] = (1.0,)

    @property
    def missing(self) -> str:
        """Why this machine cannot run it; empty if it can."""
        if self.key == "ros2-fast" and not Path("/usr/include/fastdds/dds").is_dir():
            return "Fast DDS: sudo apt-get install -y g++ libfastrtps-dev"
        if self.key == "mavlink" and shutil.which("cargo") is None:
            return "cargo, which builds the rover"
        return ""


BOARD: Final = Kind("firmware", "our firmware", firmware, 180.0)
MECANUM: Final = Kind(
    "firmware-mecanum",
    "our firmware, mecanum wheels",
    partial(firmware, base="mecanum"),
    180.0,
    way=(1.0, 0.0, 1.0),
)
"""Only for faults that need a robot that moves sideways."""
OTHERS: Final = (
    Kind("text", "lines of text", _sketch, 2000.0),
    Kind("ros2", "CycloneDDS", partial(_dds, fast=False), has_standby=True),
    Kind("ros2-fast", "Fast DDS", partial(_dds, fast=True), has_standby=True),
    Kind("rosbridge", "rosbridge", _rosbridge, has_standby=True),
    Kind("mavlink", "MAVLink", _mavlink, 1000.0),
    Kind("gpio", "pins", _pins, is_linked=False),
)
KINDS: Final = (BOARD, *OTHERS)
