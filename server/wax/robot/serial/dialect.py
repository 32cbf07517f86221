"""What the two dialects have in common: when to say what (pure)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from wax.robot.serial.setpoints import Order


class Dialect(Protocol):
    """Turns orders into bytes for the robot, and its bytes into what is known about it."""

    def hello(self, now_s: float) -> bytes:
        """Begin a connection: nothing said before counts, and the robot shall stand."""
        ...

    def say(self, order: Order, now_s: float) -> tuple[bytes, float]:
        """Give what is to be written now, often nothing, and when to ask again at the latest."""
        ...

    def farewell(self) -> bytes:
        """Make the robot stand, whatever was said before."""
        ...

    def hear(self, data: bytes, now_s: float) -> None:
        """Take what the robot has written; never raises."""
        ...

    def answers(self, now_s: float, /) -> bool:
        """Say whether the robot is there by its own account; where it tells nothing, yes."""
        ...

    def overdue(self, now_s: float, /) -> bool:
        """Say whether the robot should have answered by now and has not."""
        ...

    @property
    def moving(self) -> bool | None:
        """Whether a wheel turns by the robot's account, None where it does not tell."""
        ...

    @property
    def bumpers(self) -> int:
        """The bits of the bumpers that are pressed."""
        ...

    @property
    def battery_v(self) -> float | None:
        """The battery's voltage, None where it is not measured."""
        ...

    def known(self) -> dict[str, float]:
        """Say what else the robot has told, and how many errors were in it."""
        ...
