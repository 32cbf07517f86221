"""The turn as the gate and the latch see it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wax.control.picture_clock import PictureClock
    from wax.driver.interface import Aboard


@dataclass(frozen=True, slots=True)
class TurnView:
    """The turn as it is now.

    `present` is false while the operator's connection is lost. `one_way_s` is the delay of
    their link (`OperatorDelay`), None if unknown. `sees` is false if the picture is switched off on
    purpose or the robot has no camera. `picture` says how well the driving picture's age is known.
    `max_fraction` is how much of the robot's speed the host lets them use. `aboard` is what the
    robot last reported of the person aboard, None where there is none.
    """

    number: int
    operator: int | None
    present: bool
    one_way_s: float | None
    sees: bool
    picture: PictureClock
    max_fraction: float = 1.0
    aboard: Aboard | None = None
