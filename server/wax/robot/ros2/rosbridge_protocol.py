"""Rosbridge's protocol, version 2: JSON messages over a WebSocket (pure).

https://github.com/RobotWebTools/rosbridge_suite/blob/ros2/ROSBRIDGE_PROTOCOL.md
"""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from itertools import accumulate
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Final

from wax.robot.ros2 import members

if TYPE_CHECKING:
    from wax.driver.interface import Twist


@dataclass(frozen=True, slots=True)
class Published:
    """A message of a topic; its members are attributes, as in the ROS 2 message."""

    topic: str
    message: Any


@dataclass(frozen=True, slots=True)
class Complaint:
    """An error from the server; `about` is the operation or the number of our call.

    It is empty if the server does not say.
    """

    words: str
    about: str = ""

    @property
    def is_harmless(self) -> bool:
        """Whether only an answer or a topic is missing and everything else still works."""
        return self.about.startswith((CALLS, SUBSCRIBES)) or self.about in _MAY_REFUSE


@dataclass(frozen=True, slots=True)
class ServiceAnswer:
    """A service's answer, None if it refused or does not exist."""

    call: str
    values: Any


Heard = Published | Complaint | ServiceAnswer

CALLS: Final = "wax:"
"""The prefix of our calls' numbers."""
SUBSCRIBES: Final = "wax-subscribe:"
_MAY_REFUSE: Final = ("call_service", "subscribe")
MOST_LEVELS: Final = 32
"""The deepest nesting to accept; messages of ROS 2 have less than ten levels."""
_MAX_WORDS: Final = 200
_NO_REASON: Final = "?"
_PIECES: Final = re.compile(r'"[^"\\]*+(?:\\.[^"\\]*+)*+"?|[\[\]{}]', re.DOTALL)
"""Matches whole strings, and the brackets that open or close a level."""
_STEP: Final = {"[": 1, "{": 1, "]": -1, "}": -1}


def advertise(topic: str, type_name: str) -> str:
    """Announce that we publish; the server answers only with an error."""
    return json.dumps({"op": "advertise", "topic": topic, "type": type_name})


def subscribe(topic: str, type_name: str, *, throttle_ms: int = 0) -> str:
    """Subscribe to the newest message, at most one per `throttle_ms`."""
    return json.dumps(
        {
            "op": "subscribe",
            "id": f"{SUBSCRIBES}{topic}",
            "topic": topic,
            "type": type_name,
            "throttle_rate": throttle_ms,
            "queue_length": 1,
        }
    )


def call(number: str, service: str, **arguments: object) -> str:
    """Call a service; its answer carries the same `number`."""
    return json.dumps({"op": "call_service", "id": number, "service": service, "args": arguments})


def publish(topic: str, twist: Twist, *, stamp: tuple[int, str] | None = None) -> str:
    """Publish a set-point; `stamp` is the time in nanoseconds and the frame of a TwistStamped."""
    said: dict[str, Any] = {
        "linear": {"x": twist.linear_mps, "y": twist.lateral_mps, "z": 0.0},
        "angular": {"x": 0.0, "y": 0.0, "z": twist.angular_rps},
    }
    if stamp is not None:
        sec, nanosec = divmod(stamp[0], 1_000_000_000)
        header = {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_id": stamp[1]}
        said = {"header": header, "twist": said}
    return json.dumps({"op": "publish", "topic": topic, "msg": said})


def read(text: str) -> Heard | None:
    """Parse a server message, None if it does not concern us; raises `ValueError`."""
    if _is_deep(text):
        raise ValueError(f"a message of more than {MOST_LEVELS} levels")
    try:
        return _heard(json.loads(text, object_hook=lambda found: SimpleNamespace(**found)))
    except TypeError as error:
        raise ValueError("this is no message of rosbridge") from error


def _heard(found: object) -> Heard | None:
    match getattr(found, "op", None):
        case "publish":
            topic = members.text(getattr(found, "topic", ""))
            return Published(topic, getattr(found, "msg", None))
        case "service_response":
            done = getattr(found, "result", False) is True
            number = members.text(getattr(found, "id", ""))
            return ServiceAnswer(number, getattr(found, "values", None) if done else None)
        case "status" if getattr(found, "level", "") == "error":
            return _complaint(getattr(found, "msg", None), getattr(found, "id", None))
    return None


def _complaint(said: object, number: object) -> Complaint:
    """Parse a refusal; its subject is our call's number, else its first word, else empty."""
    words = said[:_MAX_WORDS] if isinstance(said, str) else _NO_REASON
    operation, colon, _ = words.partition(":")
    return Complaint(words, number if isinstance(number, str) else operation if colon else "")


def _is_deep(text: str) -> bool:
    """Whether it is nested deeper than any message; Python's own limit depends on its version."""
    if text.count("[") + text.count("{") <= MOST_LEVELS:
        return False
    levels = accumulate(_STEP.get(piece, 0) for piece in _PIECES.findall(text))
    return max(levels, default=0) > MOST_LEVELS
