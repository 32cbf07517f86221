"""The sentences for people when the gate, the latch or a speed rule refuses or slows down."""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Mapping

    from wax.driver.interface import HandMode

NOBODY_DRIVES: Final = "Nobody is driving."
NOT_HELD: Final = "Hold a control down to drive."
NO_LIMITS: Final = "The robot's speed limits are unknown: its driver reports no valid numbers."


class Refusal(Enum):
    """Why a command or a release does not count; the value is the sentence for its sender."""

    NOT_YOUR_TURN = "It is not your turn."
    LOST = "Your connection is lost; the robot waits for you."
    OTHER_TURN = "This command belongs to another turn."
    OUT_OF_RANGE = "A command contained a number out of range."
    OUT_OF_ORDER = "A newer command has already arrived."
    TOO_SLOW = "You can watch but not drive: your connection to the robot is too slow."
    TOO_OLD = "No fresh commands arrive: your connection is slow."
    FROM_FUTURE = "Your clock and the robot's are not synchronised yet."
    BLIND = "No fresh picture reaches you: the robot waits until you can see."
    NOT_YOUR_STOP = "Only the operator or the host can release the stop."
    THE_HOSTS_STOP = "The host has stopped the robot; only the host can release it."
    OTHER_STOP = "This stop is over, or someone has pressed Stop again."
    RELEASED_LATE = "The release arrived too late; press it again."


class Hold(Enum):
    """Why a neutral command must come first; the value is the sentence for the operator."""

    TURN_STARTED = "Your turn has begun: let go of all controls once, then drive."
    STOPPED = "Stopped: let go of all controls, then drive again."
    LOST = "Your connection was lost: let go of all controls, then drive again."
    FAULT = "The robot was not ready: let go of all controls, then drive again."
    LATE = "The server fell behind and stopped the robot: let go of all controls, then drive again."
    ABOARD = "The person aboard had the robot: let go of all controls, then drive again."
    LAPSED = "Commands or the picture were interrupted: let go of all controls, then drive again."


class Limit(Enum):
    """Why the robot is slower than commanded; the value is the sentence for the operator."""

    LATE_PICTURE = "Slow: the picture is late."
    NO_PICTURE = "Slow: you are driving without a picture."
    BY_HOST = "Slow: the host limits the speed."
    LONG_DELAY = "Slow: your connection has a long delay."
    STOPPING_DISTANCE = "Slow: the robot needs room to stop."
    SHARED = "Slow: the person aboard decides how fast."
    BUMPER = "A bumper is pressed; the robot may refuse to go that way."


NO_HAND: Final = (
    "The hand control of the person aboard does not answer: check its cable and power. Until it"
    " does, nobody drives."
)

ABOARD: Final[Mapping[HandMode, str]] = {
    "hand": "The person aboard is driving: advise them until they let go.",
    "pause": "The person aboard still has the robot: wait a moment, with all controls released.",
    "stopped": "The person aboard has pressed Stop; only they can release it, with “go on”.",
    "lost": NO_HAND,
}
"""Why an operator may not drive; ``free`` has no sentence."""

NOT_LET: Final = "The person aboard lets the robot go by pushing their stick ahead; it is at rest."


def stopped_by(name: str) -> str:
    """Return the sentence that names who pressed Stop."""
    return f"Stopped by {name}. Release the stop, then drive again."
