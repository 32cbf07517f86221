"""What hears of everything that happens in the control loop, such as the recorder."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wax.control.command import Command
    from wax.control.gate import Setpoint
    from wax.control.reasons import Refusal
    from wax.control.turns import TurnEvent
    from wax.driver.interface import Twist
    from wax.sentence import Sentence


class Listener:
    """Called once the robot has its set-point; returns at once, never raises, never calls back."""

    def command_handled(
        self, viewer: int, command: Command, refusal: Refusal | None, now_s: float
    ) -> None:
        """Receive a command that has arrived, and why the gate refused it, if it did."""

    def steered(self, wanted: Setpoint, sent: Twist, turn: int, now_s: float) -> None:
        """Receive the gate's set-point, and the twist that was actually sent to the robot."""

    def turn_events(self, events: tuple[TurnEvent, ...]) -> None:
        """Receive a change of the turns."""

    def drive_status(
        self, number: int, moving: bool, reason: Sentence | None, share: float
    ) -> None:
        """Receive a change of: the operator, whether the robot moves, why it is held or slowed, and
        the fraction of the commanded speed that it keeps.
        """
