"""The reading of a hand control aboard, and the interface of a robot that has its own.

The person aboard has a stick, buttons or both. `HandReading` is one sample of them;
`wax.control.local_hand` has the rules for what follows from it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, runtime_checkable

if TYPE_CHECKING:
    from wax.driver.interface import Ask


@dataclass(frozen=True, slots=True)
class HandReading:
    """The control's state at `at_s`, on the clock that the robot's driver was given.

    `linear`, `angular` and `lateral` are the stick, in -1…1 (ahead, turning left and sideways to
    the left are positive); one that cannot ask for sideways leaves it 0. `is_held` is set
    if the control itself senses a hand; a deflected stick counts as touched anyway. `stop` and
    `ask` are the buttons that are pressed now; `ask` is None for no button.
    """

    at_s: float
    linear: float = 0.0
    angular: float = 0.0
    is_held: bool = False
    stop: bool = False
    ask: Ask | None = None
    lateral: float = 0.0

    @property
    def is_in_range(self) -> bool:
        """Whether all numbers are in range; NaN never is."""
        return all(abs(one) <= 1.0 for one in (self.linear, self.angular, self.lateral))


@runtime_checkable
class HasHand(Protocol):
    """A robot with a hand control of its own: `[local] source = "robot"`."""

    def hand(self) -> HandReading | None:
        """Return the control's present state, None if it does not answer.

        It is called a hundred times a second, so it must return at once. A button must be reported
        while it is pressed, and for at least 20 ms.
        """
        ...


@runtime_checkable
class HasPassenger(Protocol):
    """One of WAX's own drivers, which applies the rules for a person aboard."""

    def tell_passenger(self, *, is_operated: bool) -> None:
        """Learn whether an operator is present who may drive; called before each set-point."""
        ...
