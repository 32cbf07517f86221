"""What the proof needs in order to observe the robot."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, Protocol

if TYPE_CHECKING:
    from collections.abc import Mapping

    from wax.commands.proof.measure import Event
    from wax.config.settings import Settings

Sees = Literal["line", "driver"]
"""Where a stop is seen: on the robot's line, or in the driver's process as it is called."""


class Watch(Protocol):
    """Observes the robot's commands, and whether it moves, from `open` to `close`."""

    @property
    def sees(self) -> Sees:
        """Where it observes the robot."""
        ...

    @property
    def reports(self) -> bool:
        """Whether the robot reports if it moves."""
        ...

    @property
    def skips(self) -> Mapping[str, str]:
        """Each fault that cannot be measured on this robot, with a sentence that says why."""
        ...

    def open(self) -> None:
        """Start observing; raises `DriverError`."""
        ...

    def configuration(self, settings: Settings, folder: str) -> str:
        """Return the configuration of the server under proof, whose files are in `folder`."""
        ...

    def missing(self) -> str | None:
        """Return why nothing can be measured on the robot that is connected now, None if it can."""
        ...

    def cut(self) -> None:
        """Cut the robot's link."""
        ...

    def mend(self) -> None:
        """Repair it."""
        ...

    def forget(self) -> None:
        """Start a new list of events."""
        ...

    def events(self) -> list[Event]:
        """Return the events since `forget`; raises `DriverError` if it can no longer observe."""
        ...

    def moves(self) -> bool:
        """Whether the robot moves now, as far as it is known."""
        ...

    def close(self) -> None:
        """Stop the robot if possible, and stop observing; never raises, safe to call twice."""
        ...

    async def ended(self) -> None:
        """Wait until the robot is released, once its server has ended."""
        ...
