"""A driver that does nothing: the base of every fake that notes, sees or fails."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.driver.interface import Limits, RobotState

if TYPE_CHECKING:
    from wax.driver.interface import Twist


class IdleRobot:
    """Is connected, and does nothing that it is told."""

    kind: str = "idle"
    limits: Limits = Limits(1.0, 1.0)

    def open(self) -> None: ...

    def apply(self, twist: Twist, turn: int) -> None: ...

    def set_axis(self, name: str, position: float, turn: int) -> None: ...

    def stop(self, turn: int) -> None: ...

    def close(self) -> None: ...

    def state(self) -> RobotState:
        return RobotState(connected=True, epoch=1)
