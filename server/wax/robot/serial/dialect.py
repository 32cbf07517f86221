"""The interface of the three dialects (pure)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from wax.driver.interface import Reading
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
    def reading(self) -> Reading:
        """What the robot reports; `extra` has the number of errors in its data, too."""
        ...
