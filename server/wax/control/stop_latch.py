"""The stop that anybody can press and that lasts until it is released.

Each stop has a rising number, and a release names the stop that it is for. A release for an earlier
stop, one that took too long to arrive, or one sent before somebody pressed again has no effect.
Only the host can release a stop that the host has pressed, even if others pressed it, too. An
operator may not release somebody else's stop for the first seconds, so that a bystander has time to
act. A release moves nothing: afterwards the loop waits for a neutral command.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal

from wax.control.command_freshness import is_from_future, is_too_old
from wax.control.reasons import Refusal

if TYPE_CHECKING:
    from wax.control.turn_view import TurnView
    from wax.sentence import Sentence

Releaser = int | Literal["host", "house"] | None
"""A viewer's number, the host, the host's home automation, or None for somebody unknown."""

RELEASE_TTL_S: Final = 2.0
"""An older release no longer counts as deliberate."""


@dataclass(frozen=True, slots=True)
class LatchedStop:
    """A stop in force; `by` names who pressed it first, `viewer` is their number if in the room.

    `by_host` is true once the host has pressed it, first or later.
    """

    number: int
    by: Sentence
    viewer: int | None = None
    by_host: bool = False


@dataclass(frozen=True, slots=True)
class StopLatch:
    """`newest` is the number of the newest stop, 0 before the first; `stop` the one in force.

    Before `releasable_s` only one operator may release it: `sole_presser`, if nobody else has
    pressed it. `sole_presser` is None if there is no such viewer.
    """

    newest: int = 0
    stop: LatchedStop | None = None
    pressed_s: float = -math.inf
    releasable_s: float = -math.inf
    sole_presser: int | None = None


def adds_nothing(latch: StopLatch, viewer: int | None, now_s: float) -> bool:
    """Return whether a press by this viewer would leave the stop in force as it is."""
    return now_s < latch.releasable_s and latch.sole_presser in (None, viewer)


def press(
    latch: StopLatch,
    by: Sentence,
    now_s: float,
    *,
    viewer: int | None = None,
    by_host: bool = False,
    release_after_s: float = 0.0,
) -> StopLatch:
    """Latch a stop; pressing again keeps its number and the name.

    An operator may release it only after `release_after_s`. A second viewer's press within that
    time restarts it, but only once: repeated presses must not hold the robot for ever.

    A second press invalidates every release sent before it, even though the number stays: with a
    new number, somebody who keeps pressing would turn every release into one for an earlier stop.
    """
    stop = latch.stop or LatchedStop(latch.newest + 1, by, viewer)
    stop = replace(stop, by_host=stop.by_host or by_host)
    if adds_nothing(latch, viewer, now_s):
        return replace(latch, stop=stop, pressed_s=now_s)
    return StopLatch(
        newest=stop.number,
        stop=stop,
        pressed_s=now_s,
        releasable_s=now_s + release_after_s,
        sole_presser=None if now_s < latch.releasable_s else viewer,
    )


def release(
    latch: StopLatch,
    by: Releaser,
    stop: int,
    sent_s: float | None,
    *,
    turn: TurnView,
    now_s: float,
) -> tuple[StopLatch, Refusal | None]:
    """Release the stop with the number `stop`, or return why not.

    A connected operator, the host and the house may release it. `sent_s` is None for a request
    without a timestamp, over a transport that does not delay requests.
    """
    refusal = _not_entitled(by, turn, latch.stop)
    if refusal is None and (latch.stop is None or stop != latch.stop.number):
        refusal = Refusal.OTHER_STOP
    if refusal is None and sent_s is not None:
        refusal = _untimely(latch, sent_s, turn.one_way_s if isinstance(by, int) else None, now_s)
    if refusal is None and _is_early(latch, by, now_s):
        refusal = Refusal.RELEASED_EARLY
    if refusal is not None:
        return latch, refusal
    return StopLatch(newest=latch.newest, pressed_s=latch.pressed_s), None


def _not_entitled(by: Releaser, turn: TurnView, stop: LatchedStop | None) -> Refusal | None:
    if by == "host":
        return None
    if by is None or by not in (turn.operator, "house"):
        return Refusal.NOT_YOUR_STOP
    if stop is not None and stop.by_host:
        return Refusal.THE_HOSTS_STOP
    return None if turn.present or by == "house" else Refusal.LOST


def _is_early(latch: StopLatch, by: Releaser, now_s: float) -> bool:
    return isinstance(by, int) and by != latch.sole_presser and now_s < latch.releasable_s


def _untimely(
    latch: StopLatch, sent_s: float, one_way_s: float | None, now_s: float
) -> Refusal | None:
    if is_too_old(sent_s, now_s, RELEASE_TTL_S):
        return Refusal.RELEASED_LATE
    if is_from_future(sent_s, now_s, one_way_s=one_way_s):
        return Refusal.FROM_FUTURE
    return Refusal.OTHER_STOP if sent_s < latch.pressed_s else None
