"""The connection to a robot that speaks ROS 2, by whichever way."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from wax.robot.ros2 import names

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.driver.interface import Twist
    from wax.robot.ros2.command_topic import Traffic
    from wax.robot.ros2.settings import Ros2Settings


@dataclass(frozen=True, slots=True)
class Wanted:
    """A topic to subscribe to; `kind` is how its messages are handed over."""

    kind: str
    topic: str
    type_name: str


class Link(Protocol):
    """One connection, open from the start; one thread sends, another takes.

    Every method but `close` raises `DriverError` when the connection is lost.
    """

    @property
    def guid(self) -> str:
        """What tells our publisher from another's; empty where that cannot be told."""
        ...

    def send(self, twist: Twist, wall_ns: int) -> None:
        """Publish a set-point; `wall_ns` is now, for who wants a stamp."""
        ...

    def take(self, timeout_s: float) -> Sequence[tuple[str, Any]]:
        """Wait for messages at most so long; return the newest of each kind, with its kind."""
        ...

    def traffic(self) -> Traffic:
        """Return who is on the topic of the commands."""
        ...

    def close(self) -> None:
        """Let go of it once what was sent is on its way; safe to call twice."""
        ...


def command_type(settings: Ros2Settings) -> str:
    """Return the type of the commands, as ROS 2 writes it."""
    return names.TWIST_STAMPED if settings.stamped else names.TWIST
