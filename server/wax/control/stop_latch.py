"""The stop that anybody presses and that lasts until it is released, across turns.

Each stop has a number that only rises, and a release names the one that it means: one that was
meant for an earlier stop, was under way for long, or was sent before somebody pressed again,
releases nothing. A release moves nothing either; the loop asks for a neutral command after it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal

from wax.control.command_freshness import is_from_future, is_too_old
from wax.control.reasons import Refusal

if TYPE_CHECKING:
    from wax.control.turn_view import TurnView

Releaser = int | Literal["host"] | None
"""A viewer by their number, the host, or somebody unknown."""

RELEASE_TTL_S: Final = 2.0
"""A release that was sent longer ago is no deliberate act of this moment any more."""


@dataclass(frozen=True, slots=True)
class LatchedStop:
    """A stop that is latched, and who pressed it first."""

    number: int
    by: str


@dataclass(frozen=True, slots=True)
class StopLatch:
    """`newest` is the number of the newest stop, 0 before the first; `stop` the one that lasts."""

    newest: int = 0
    stop: LatchedStop | None = None
    pressed_s: float = -math.inf


def press(latch: StopLatch, by: str, now_s: float) -> StopLatch:
    """Latch a stop. Pressing again gives the one that lasts a new number, and keeps its name.

    So a release that was meant before somebody pressed again releases nothing, by whichever way
    it comes and however long that takes.
    """
    number = latch.newest + 1
    by = by if latch.stop is None else latch.stop.by
    return StopLatch(newest=number, stop=LatchedStop(number, by), pressed_s=now_s)


def release(
    latch: StopLatch,
    by: Releaser,
    stop: int,
    sent_s: float | None,
    *,
    turn: TurnView,
    now_s: float,
) -> tuple[StopLatch, Refusal | None]:
    """End the stop with the number `stop`, or say why not.

    The operator may while they are connected, and the host. `sent_s` None is a request without a
    stamp, by a way that keeps none for long.
    """
    refusal = _not_entitled(by, turn)
    if refusal is None and (latch.stop is None or stop != latch.stop.number):
        refusal = Refusal.OTHER_STOP
    if refusal is None and sent_s is not None:
        refusal = _untimely(latch, sent_s, None if by == "host" else turn.one_way_s, now_s)
    return (replace(latch, stop=None) if refusal is None else latch), refusal


def _not_entitled(by: Releaser, turn: TurnView) -> Refusal | None:
    if by == "host":
        return None
    if by is None or by != turn.operator:
        return Refusal.NOT_YOUR_STOP
    return None if turn.present else Refusal.LOST


def _untimely(
    latch: StopLatch, sent_s: float, one_way_s: float | None, now_s: float
) -> Refusal | None:
    if is_too_old(sent_s, now_s, RELEASE_TTL_S):
        return Refusal.RELEASED_LATE
    if is_from_future(sent_s, now_s, one_way_s=one_way_s):
        return Refusal.FROM_FUTURE
    return Refusal.OTHER_STOP if sent_s < latch.pressed_s else None
