"""What a hand control aboard says, and how a robot offers its own.

The person aboard has a stick, buttons or both. `HandReading` is one look at them; the rules for
what follows from it are `wax.control.local_hand`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, runtime_checkable

if TYPE_CHECKING:
    from wax.driver.interface import Ask


@dataclass(frozen=True, slots=True)
class HandReading:
    """The control at `at_s`, on the clock that the robot's driver was given.

    `linear` and `angular` are the stick, in -1…1 (ahead and left are positive). `is_held` is set
    where the control itself feels a hand; a deflected stick counts as touched without it. `stop`
    and `ask` are the buttons that are pressed now, None for no button.
    """

    at_s: float
    linear: float = 0.0
    angular: float = 0.0
    is_held: bool = False
    stop: bool = False
    ask: Ask | None = None

    @property
    def is_in_range(self) -> bool:
        """Whether both numbers are in range; NaN is in none."""
        return abs(self.linear) <= 1.0 and abs(self.angular) <= 1.0


@runtime_checkable
class HasHand(Protocol):
    """A robot with a hand control of its own: `[local] source = "robot"`."""

    def hand(self) -> HandReading | None:
        """Return what the control says now, None if it does not answer.

        Called a hundred times a second, so it must return at once. A button must be reported for
        as long as it is pressed, and for at least 20 ms.
        """
        ...


@runtime_checkable
class HasPassenger(Protocol):
    """A driver of WAX's own that carries out the rules of a person aboard."""

    def tell_passenger(self, *, is_operated: bool) -> None:
        """Take, before each set-point, whether an operator is there who may drive."""
        ...
