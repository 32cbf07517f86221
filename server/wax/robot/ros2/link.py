"""The interface of a connection to a ROS 2 robot."""

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
    """A topic to subscribe to; `kind` labels its messages."""

    kind: str
    topic: str
    type_name: str


class Link(Protocol):
    """One connection, open from the start; one thread calls `send`, another `take`.

    Every method but `close` raises `DriverError` when the connection is lost.
    """

    @property
    def guid(self) -> str:
        """The identifier of our publisher, empty if unknown."""
        ...

    def send(self, twist: Twist, wall_ns: int) -> None:
        """Publish a set-point; `wall_ns` is the time for a message with a timestamp."""
        ...

    def take(self, timeout_s: float) -> Sequence[tuple[str, Any]]:
        """Wait up to `timeout_s` for messages; return the newest of each kind, with its kind."""
        ...

    def traffic(self) -> Traffic:
        """Return who publishes and subscribes on the command topic."""
        ...

    def close(self) -> None:
        """Close it once sent messages are on their way; safe to call twice."""
        ...


def command_type(settings: Ros2Settings) -> str:
    """Return the message type of the commands in ROS 2's notation."""
    return names.TWIST_STAMPED if settings.stamped else names.TWIST
