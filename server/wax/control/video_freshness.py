"""How fresh the operator's picture is: fresh, late, switched off, or too old to drive by.

Its age is that of the newest picture on the operator's screen, as each command reports it, minus
the estimated delay of their link, plus the error of the source's clock: a picture of unknown age
(`PictureClock`) counts as none. The age grows between commands too. An operator who has switched
the picture off, or drives a robot without a camera, knows that they see nothing. NaN is never
fresh.
"""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING

from wax.control.command_freshness import allowance_s, is_from_future

if TYPE_CHECKING:
    from wax.control.rules import Rules
    from wax.control.turn_view import TurnView


class VideoFreshness(Enum):
    """How well the operator sees where the robot is going."""

    CLEAR = "a fresh picture"
    LATE = "a late picture: the robot is slowed"
    OFF = "no picture, on purpose: the robot is slowed"
    NONE = "no picture, or one that is far too old: the robot stops"


def credible_seen_s(seen_s: float | None, now_s: float, one_way_s: float | None) -> float | None:
    """Return the capture time to use for the picture that the page reports.

    A time slightly in the future counts as now, so that the picture does not last longer; one
    further ahead counts as no picture.
    """
    if seen_s is None or is_from_future(seen_s, now_s, one_way_s=one_way_s):
        return None
    return min(seen_s, now_s)


def judge(seen_s: float | None, now_s: float, turn: TurnView, rules: Rules) -> VideoFreshness:
    """Judge the operator's picture at `now_s`; the newest they see was captured at `seen_s`."""
    if not turn.sees:
        return VideoFreshness.OFF
    if seen_s is None or seen_s < turn.picture.since_s:
        return VideoFreshness.NONE
    age_s = now_s - seen_s + turn.picture.within_s - allowance_s(turn.one_way_s)
    if age_s <= rules.slow_picture_age_s:
        return VideoFreshness.CLEAR
    return VideoFreshness.LATE if age_s <= rules.stop_picture_age_s else VideoFreshness.NONE
