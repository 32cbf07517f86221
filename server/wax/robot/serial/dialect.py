"""The interface of the three dialects (pure)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from wax.driver.interface import Pose
    from wax.robot.line.setpoints import Order
    from wax.sentence import Sentence


class Dialect(Protocol):
    """Turns orders into bytes for the robot, and the robot's bytes into its state."""

    def hello(self, now_s: float) -> bytes:
        """Begin a connection: reset all state and stop the robot."""
        ...

    def data_to_send(self, order: Order, now_s: float) -> tuple[bytes, float]:
        """Return the bytes to write now, often none, and the latest time of the next call."""
        ...

    def farewell(self) -> bytes:
        """Return the bytes that stop the robot, whatever was sent before."""
        ...

    def receive_data(self, data: bytes, now_s: float) -> None:
        """Handle data from the robot; never raises."""
        ...

    def answers(self, now_s: float, /) -> bool:
        """Whether the robot is answering; True for a dialect without reports."""
        ...

    def overdue(self, now_s: float, /) -> bool:
        """Whether the robot's answer is overdue."""
        ...

    def complaint(self, port: str, /) -> Sentence:
        """Return the problem while the robot does not answer, and what to do."""
        ...

    @property
    def moving(self) -> bool | None:
        """Whether the robot reports that a wheel turns, None if it does not report."""
        ...

    @property
    def bumpers(self) -> int:
        """The pressed bumpers, one bit each."""
        ...

    @property
    def battery_v(self) -> float | None:
        """The battery's voltage, None if it is not measured."""
        ...

    @property
    def pose(self) -> Pose | None:
        """The robot's pose by its wheel odometry, None if unknown."""
        ...

    def known(self) -> dict[str, float]:
        """Return the robot's other values, and the number of errors in its data."""
        ...
