"""The sentences shown when the gate, the latch or a speed rule refuses a command or slows it."""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING, Final

from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Mapping

    from wax.driver.interface import HandMode

NOBODY_DRIVES: Final = Sentence("drive.nobody")
NOT_HELD: Final = Sentence("drive.not_held")
NO_LIMITS: Final = Sentence("drive.no_limits")


class Refusal(Enum):
    """Why a command or a release does not count; the value is the sentence for its sender."""

    NOT_YOUR_TURN = Sentence("drive.not_your_turn")
    LOST = Sentence("drive.lost")
    OTHER_TURN = Sentence("drive.other_turn")
    OUT_OF_RANGE = Sentence("drive.out_of_range")
    OUT_OF_ORDER = Sentence("drive.out_of_order")
    TOO_SLOW = Sentence("drive.too_slow")
    TOO_OLD = Sentence("drive.too_old")
    FROM_FUTURE = Sentence("drive.from_future")
    BLIND = Sentence("drive.blind")
    UNDATED = Sentence("drive.undated")
    NOT_YOUR_STOP = Sentence("stop.not_yours")
    THE_HOSTS_STOP = Sentence("stop.the_hosts")
    OTHER_STOP = Sentence("stop.other")
    RELEASED_EARLY = Sentence("stop.released_early")
    RELEASED_LATE = Sentence("stop.released_late")
    NO_SUCH_CONTROL = Sentence("control.unknown")
    NOT_YOUR_CONTROL = Sentence("control.not_yours")
    STOPPED = Sentence("control.stopped")


class Hold(Enum):
    """Why a neutral command must come first; the value is the sentence for the operator."""

    TURN_STARTED = Sentence("hold.turn_started")
    STOPPED = Sentence("hold.stopped")
    LOST = Sentence("hold.lost")
    FAULT = Sentence("hold.fault")
    LATE = Sentence("hold.late")
    ABOARD = Sentence("hold.aboard")
    LAPSED = Sentence("hold.lapsed")


class Limit(Enum):
    """Why the robot is slower than commanded; the value is the sentence for the operator."""

    LATE_PICTURE = Sentence("limit.late_picture")
    NO_PICTURE = Sentence("limit.no_picture")
    BY_HOST = Sentence("limit.by_host")
    LONG_DELAY = Sentence("limit.long_delay")
    STOPPING_DISTANCE = Sentence("limit.stopping_distance")
    SHARED = Sentence("limit.shared")
    BUMPER = Sentence("limit.bumper")


NO_HAND: Final = Sentence("aboard.lost")

ABOARD: Final[Mapping[HandMode, Sentence]] = {
    "hand": Sentence("aboard.hand"),
    "pause": Sentence("aboard.pause"),
    "stopped": Sentence("aboard.stopped"),
    "lost": NO_HAND,
}
"""Why an operator may not drive; ``free`` has no sentence."""

NOT_LET: Final = Sentence("aboard.not_let")


def stopped_by(by: Sentence) -> Sentence:
    """Return the sentence that names who pressed Stop."""
    return Sentence("stop.pressed", {"by": by})
