"""The base class of every driver on a line."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.robot.line.kept_line import CLOSE_S, KeptLine

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.driver.interface import Limits, RobotState, Twist
    from wax.robot.line.core import LineCore
    from wax.robot.line.kept_line import RobotLine


class LineRobot:
    """A `Driver` whose `core` decides and whose `line` carries it out, in threads of its own."""

    def __init__(
        self,
        kind: str,
        limits: Limits,
        clock: Clock,
        core: LineCore,
        line: RobotLine,
        *,
        reopen_s: float,
        close_s: float = CLOSE_S,
    ) -> None:
        self._kind = kind
        self._limits = limits
        self._clock = clock
        self._core = core
        self._kept = KeptLine(kind, line, core, clock, reopen_s=reopen_s, close_s=close_s)

    @property
    def kind(self) -> str:
        return self._kind

    @property
    def limits(self) -> Limits:
        return self._limits

    def open(self) -> None:
        """Start connecting, and keep trying; `state` reports whether the robot is connected."""
        self._kept.open()

    def apply(self, twist: Twist, turn: int) -> None:
        self._core.apply(twist, turn, self._clock.now_s())
        self._kept.wake()

    def set_axis(self, name: str, position: float, turn: int) -> None:
        self._core.set_axis(name, position, turn)
        self._kept.wake()

    def stop(self, turn: int) -> None:
        self._core.stop(turn, self._clock.now_s())
        self._kept.wake()

    def close(self) -> None:
        self._kept.close()

    def state(self) -> RobotState:
        return self._core.state(self._clock.now_s())
