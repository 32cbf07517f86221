"""Who hears of every command and every set-point, as the tape does."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from wax.control.command import Command
    from wax.control.gate import Setpoint
    from wax.control.reasons import Refusal
    from wax.driver.interface import Twist


class Listener(Protocol):
    """Called once the robot has its set-point; returns at once, never raises, never calls back."""

    def offered(self, viewer: int, command: Command, refusal: Refusal | None, now_s: float) -> None:
        """Hear of a command that has arrived, and why the gate refused it."""
        ...

    def steered(self, wanted: Setpoint, sent: Twist, turn: int, now_s: float) -> None:
        """Hear what the gate wants of the robot, and what it was given."""
        ...


class NoListener:
    """Nobody listens."""

    def offered(
        self, viewer: int, command: Command, refusal: Refusal | None, now_s: float
    ) -> None: ...

    def steered(self, wanted: Setpoint, sent: Twist, turn: int, now_s: float) -> None: ...
