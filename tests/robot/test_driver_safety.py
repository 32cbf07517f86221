"""Every driver that comes with WAX keeps the promises of `wax.testing`."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any, ClassVar, Final

import pytest
from tests.firmware.core import Core, Kind, Settings

from wax.config.local import LocalSettings
from wax.config.robot import RobotSettings
from wax.driver.interface import STANDSTILL, Limits, Twist
from wax.robot.find_driver import make_driver, make_robot
from wax.robot.serial.frames import DriveBody, HelloBody, MoveBody, StopBody
from wax.robot.wheels import WheelGeometry
from wax.testing import DriverSafety

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tests.robot.conftest import Board

    from wax.clock import Clock
    from wax.driver.interface import Driver
    from wax.robot.serial.frames import Body

DIRECTIONS: Final = {
    b"F": (1, 0),
    b"B": (-1, 0),
    b"L": (0, 1),
    b"R": (0, -1),
    b"G": (1, 1),
    b"I": (1, -1),
    b"H": (-1, 1),
    b"J": (-1, -1),
}
"""The commands of 2004: ahead and left, from -1 to 1."""


class Ours(DriverSafety):
    """A driver that takes its limits from the configuration."""

    kind: ClassVar = "serial"
    ttl_s: ClassVar[float | None] = None

    def test_its_limits_are_the_configured_ones(self, driver: Driver) -> None:
        """Kind and limits are known before it is opened, and are the configured ones."""
        assert driver.kind == self.kind
        assert (driver.limits.linear_mps, driver.limits.angular_rps) == (0.6, 1.5)
        assert driver.limits.ttl_s == self.ttl_s


class TestSimulated(Ours):
    """Observed by its motion."""

    kind = "simulated"
    ttl_s = 0.3
    braking_s = 0.1
    base: ClassVar = "differential"

    def make_driver(self, clock: Clock) -> Driver:
        robot = make_driver(RobotSettings.model_validate({"base": self.base}), clock)
        self._seen = getattr(self, "_seen", None) or robot
        return robot

    def commanded(self) -> Sequence[Twist]:
        extra = self._seen.state().extra
        return [Twist(extra["speed_mps"], 0.0, extra.get("lateral_mps", 0.0))]


@pytest.mark.full
class TestSimulatedSideways(TestSimulated):
    base = "mecanum"


class TestSimulatedWithSomebodyAboard(TestSimulated):
    def make_driver(self, clock: Clock) -> Driver:
        local = LocalSettings(source="robot", pause_s=0.5)
        robot = make_robot(RobotSettings(), clock, local=local)
        self._seen = getattr(self, "_seen", None) or robot
        return robot


@pytest.mark.system
class TestSerialFrames(Ours):
    """Observed on the line to the real firmware's core."""

    dialect: ClassVar = "frames"
    base: ClassVar = "differential"
    text: ClassVar[dict[str, Any]] = {}
    ttl_s: ClassVar[float | None] = 0.2

    @pytest.fixture(autouse=True)
    def _robot(self, board: Board) -> None:
        self.board = board
        self._taken = 0

    @property
    def settings(self) -> RobotSettings:
        serial: dict[str, Any] = {"url": str(self.board.path), "dialect": self.dialect}
        serial |= {"axes": ["pan"], "reopen_s": 0.05, "text": self.text}
        tree = {"driver": "serial", "base": self.base, "serial": serial}
        return RobotSettings.model_validate(tree)

    def make_driver(self, clock: Clock) -> Driver:
        return make_driver(self.settings, clock)

    def commanded(self) -> Sequence[Twist]:
        frames = self.board.frames()[self._taken :]
        self._taken += len(frames)
        return [twist for frame in frames if (twist := self._twist(frame.body)) is not None]

    def cut(self) -> None:
        self.board.unplug()

    def mend(self) -> None:
        self._taken = 0
        self.board.plug()

    def _twist(self, body: Body) -> Twist | None:
        match body:
            case DriveBody(left, right):
                aside_mps = (right - left) / 2000.0
                half_base_m = self.settings.wheel_base_m / 2.0
                return Twist((left + right) / 2000.0, aside_mps / half_base_m)
            case StopBody() | HelloBody():
                return STANDSTILL
        return None


class TestSerialFramesSideways(TestSerialFrames):
    """A board with mecanum wheels, which is told motions."""

    @pytest.fixture(autouse=True)
    def _mecanum(self, _robot: None) -> None:
        self.board.core = Core(Settings(kind=Kind.MECANUM), int(time.monotonic() * 1000.0))

    @property
    def settings(self) -> RobotSettings:
        return super().settings.model_copy(update={"base": "mecanum"})

    def _twist(self, body: Body) -> Twist | None:
        if isinstance(body, MoveBody):
            mmps = body.linear_mmps, body.angular_mradps, body.lateral_mmps
            return Twist(*(one / 1000.0 for one in mmps))
        return super()._twist(body)


class TestSerialBytes(TestSerialFrames):
    """The commands have no speed, so each counts as the fastest."""

    dialect = "bytes"
    ttl_s = None  # it follows the last command for ever

    def commanded(self) -> Sequence[Twist]:
        heard = self.board.heard[self._taken :]
        self._taken += len(heard)
        told = [bytes([octet]) for octet in heard]
        return [self._fastest(octet) for octet in told if octet == b"S" or octet in DIRECTIONS]

    def _fastest(self, octet: bytes) -> Twist:
        limits = Limits(self.settings.max_linear_mps, self.settings.max_angular_rps)
        ahead, left = DIRECTIONS.get(octet, (0, 0))
        return Twist(ahead * limits.linear_mps, left * limits.angular_rps)


class TestSerialText(TestSerialFrames):
    """Lines with the wheels' speeds in mm/s, for a board that is said to stop after 300 ms."""

    dialect = "text"
    text: ClassVar[dict[str, Any]] = {
        "drive": "m {left} {right}\r",
        "per_mps": 1000.0,
        "ttl_ms": 300,
        "boot_ms": 0,
        "axis": [{"line": "s {position:.2f}\r"}],
    }
    ttl_s = 0.3

    def commanded(self) -> Sequence[Twist]:
        whole, end, _ = self.board.heard[self._taken :].rpartition(b"\r")
        self._taken += len(whole + end)
        lines = [line.split() for line in whole.split(b"\r") if line[:1] == b"m"]
        return [self._of_wheels([int(word) for word in words[1:]]) for words in lines]

    def _of_wheels(self, mmps: list[int]) -> Twist:
        return self._twist(DriveBody(*mmps)) or STANDSTILL


@pytest.mark.full
class TestSerialFramesInItsProcess(TestSerialFrames):
    """The same robot in a process of its own, as in the server."""

    def make_driver(self, clock: Clock) -> Driver:
        return make_robot(self.settings, clock)


@pytest.mark.full
class TestSerialBytesInItsProcess(TestSerialBytes):
    def make_driver(self, clock: Clock) -> Driver:
        return make_robot(self.settings, clock)


@pytest.mark.full
class TestSerialTextInItsProcess(TestSerialText):
    def make_driver(self, clock: Clock) -> Driver:
        return make_robot(self.settings, clock)


@pytest.mark.full
class TestSerialTextOfFourWheels(TestSerialText):
    """Lines for four mecanum wheels, which move it sideways, too."""

    base = "mecanum"
    text: ClassVar[dict[str, Any]] = TestSerialText.text | {
        "drive": "m {front_left} {front_right} {back_left} {back_right}\r"
    }

    def _of_wheels(self, mmps: list[int]) -> Twist:
        return WheelGeometry(self.settings).motion([one / 1000.0 for one in mmps])
