"""What the gate, the latch and the speed rules say when they say no, or not so fast."""

from __future__ import annotations

from enum import Enum
from typing import Final

NOBODY_DRIVES: Final = "Nobody is driving."
NOT_HELD: Final = "Nothing is held: hold a control down to drive."
NO_LIMITS: Final = "How fast the robot may be is not known; its driver's limits are no numbers."


class Refusal(Enum):
    """Why a command or a release does not count; the value is the sentence for its sender."""

    NOT_YOUR_TURN = "It is not your turn."
    LOST = "Your connection is lost; the robot waits for you."
    OTHER_TURN = "This command belongs to another turn."
    OUT_OF_RANGE = "A command held a number that is out of range."
    OUT_OF_ORDER = "A newer command has arrived already."
    TOO_SLOW = "You can watch, not drive: the line to the robot takes too long."
    TOO_OLD = "No fresh command: the link is late."
    FROM_FUTURE = "Your clock and the robot's are not aligned yet."
    BLIND = "No fresh picture reaches you: the robot waits until you see."
    NOT_YOUR_STOP = "Only whoever drives, or the robot's host, can release the stop."
    OTHER_STOP = "This stop is over, or somebody has pressed Stop again."
    RELEASED_LATE = "The release came too late; press it again."


class Hold(Enum):
    """Why a neutral command must come first; the value is the sentence for the operator."""

    TURN_STARTED = "Your turn has begun: let go of all controls once, then drive."
    STOPPED = "Stopped: let go of all controls, then drive again."
    LOST = "Your connection was lost: let go of all controls, then drive again."
    FAULT = "The robot was not ready: let go of all controls, then drive again."
    LATE = "The server was late and stopped the robot: let go of all controls, then drive again."
    LAPSED = "The link or the picture was gone: let go of all controls, then drive again."


class Limit(Enum):
    """Why the robot is slower than it is told; the value is the sentence for the operator."""

    LATE_PICTURE = "Slow: the picture is late."
    NO_PICTURE = "Slow: you drive without a picture."
    LONG_LINE = "Slow: the line is long."
    STOPPING_DISTANCE = "Slow: the robot needs room to stop."
    BUMPER = "A bumper is pressed; the robot may not go that way."


def stopped_by(name: str) -> str:
    """Say who has pressed Stop."""
    return f"Stopped by {name}. Release the stop, then drive again."
