"""The interface for observers of every command and set-point, such as the recorder."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from wax.control.command import Command
    from wax.control.gate import Setpoint
    from wax.control.reasons import Refusal
    from wax.driver.interface import Twist


class Listener(Protocol):
    """Called once the robot has its set-point; returns at once, never raises, never calls back."""

    def command_handled(
        self, viewer: int, command: Command, refusal: Refusal | None, now_s: float
    ) -> None:
        """Receive a command that has arrived, and why the gate refused it, if it did."""
        ...

    def steered(self, wanted: Setpoint, sent: Twist, turn: int, now_s: float) -> None:
        """Receive the gate's set-point, and the twist that was actually sent to the robot."""
        ...


class NoListener:
    """A listener that ignores everything."""

    def command_handled(
        self, viewer: int, command: Command, refusal: Refusal | None, now_s: float
    ) -> None: ...

    def steered(self, wanted: Setpoint, sent: Twist, turn: int, now_s: float) -> None: ...
