"""What the control loop asks about those who drive."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from wax.sentence import Sentence


class Operators(Protocol):
    """The viewers and the host's decisions about them (`wax.session.viewers`)."""

    @property
    def on_hold(self) -> Sentence | None:
        """Why the host lets nobody drive; None if people may."""
        ...

    def link_delay_s(self, number: int) -> float | None:
        """Return half of a viewer's shortest recent round trip, None before the first."""
        ...

    def sees(self, number: int) -> bool:
        """Whether a viewer wants the picture: not if it is off or the robot has no camera."""
        ...

    def max_fraction(self, number: int) -> float:
        """Return how much of the robot's speed the host lets a viewer use."""
        ...
