"""The robot's end of a line of frames, and dialects that talk to it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.config.robot import RobotSettings
from wax.driver.interface import Limits, Twist
from wax.robot.line.setpoints import Order
from wax.robot.serial.frames import (
    Body,
    Decoder,
    Frame,
    ReportBody,
    encode,
)
from wax.robot.serial.frames_dialect import FramesDialect
from wax.robot.serial.odometry import Odometry
from wax.robot.wheels import WheelMixer

if TYPE_CHECKING:
    from wax.robot.serial.bytes_dialect import BytesDialect

LIMITS = Limits(linear_mps=0.6, angular_rps=1.5)


def going(ahead: float, left: float, turn: int = 1) -> Order:
    """Shares of the limits."""
    return Order(Twist(ahead * LIMITS.linear_mps, left * LIMITS.angular_rps), turn)


def framed(*, moves_sideways: bool = False) -> FramesDialect:
    settings = RobotSettings()
    return FramesDialect(
        *(WheelMixer(settings), 200, ("pan", "lamp"), Odometry(settings)),
        moves_sideways=moves_sideways,
    )


class Robot:
    """The robot's end: it decodes what the dialect sends, and answers on request."""

    def __init__(self) -> None:
        self.decoder = Decoder()
        self.heard: list[Frame] = []

    def hear(self, wire: bytes) -> list[Body]:
        found = self.decoder.feed(wire)
        self.heard += found
        assert self.decoder.errors == 0
        return [frame.body for frame in found]

    def answer(
        self, dialect: FramesDialect, now_s: float, time_ms: int = 0, **report: int
    ) -> ReportBody:
        """Report the last frame heard as taken."""
        fields = {"battery_mv": 0, "bumpers": 0, "left_ticks": 0, "right_ticks": 0, "flags": 0}
        fields |= {"sequence": self.heard[-1].sequence} | report
        said = ReportBody(**fields)
        dialect.receive_data(encode(Frame(said, time_ms=time_ms), self.decoder.session), now_s)
        return said


def connected(now_s: float = 1.0, time_ms: int = 0) -> tuple[FramesDialect, Robot]:
    """Give a dialect whose hello was answered at once."""
    dialect, robot = framed(), Robot()
    robot.hear(dialect.hello(now_s))
    robot.answer(dialect, now_s, time_ms)
    return dialect, robot


def says(dialect: BytesDialect | FramesDialect, order: Order, now_s: float) -> tuple[bytes, float]:
    words, due_s = dialect.data_to_send(order, now_s)
    return words, round(due_s, 6)
