"""The messages of an exported MCAP file: Foxglove's own, and one for each kind of event. Pure.

Foxglove, Lichtblick and Rerun show pictures, poses and logs of these schemas
(https://docs.foxglove.dev/docs/sdk/schemas), and the numbers of any.
"""

from __future__ import annotations

import math
from functools import cache, partial
from types import NoneType
from typing import TYPE_CHECKING, Any, Final, get_args, get_origin

from wax.dataset.protobuf import Enum, Field, MessageType, message_type
from wax.protocol.tape_events import (
    Faulted,
    Missed,
    Reported,
    Steered,
    Stopped,
    Tasked,
    Turned,
)

_Said = tuple[str, str, str]
"""Who says it, its level, and the words."""

if TYPE_CHECKING:
    from wax.protocol.tape_events import TapeEvent

_TIMESTAMP: Final = message_type("google.protobuf", "Timestamp", seconds="int64", nanos="int32")
_foxglove = partial(message_type, "foxglove")
_timed = partial(_foxglove, timestamp=_TIMESTAMP)

IMAGE: Final = _timed("CompressedImage", data="bytes", format="string", frame_id="string")
VIDEO: Final = _timed("CompressedVideo", frame_id="string", data="bytes", format="string")
AUDIO: Final = _timed(
    "RawAudio", data="bytes", format="string", sample_rate="fixed32", number_of_channels="fixed32"
)
_VECTOR: Final = _foxglove("Vector3", x="double", y="double", z="double")
_QUATERNION: Final = _foxglove("Quaternion", x="double", y="double", z="double", w="double")
_POSE: Final = _foxglove("Pose", position=_VECTOR, orientation=_QUATERNION)
POSE: Final = _timed("PoseInFrame", frame_id="string", pose=_POSE)
_LEVEL: Final = Enum("Level", ("UNKNOWN", "DEBUG", "INFO", "WARNING", "ERROR", "FATAL"))
LOG: Final = _timed("Log", level=_LEVEL, message="string", name="string")

_NUMBER: Final = message_type("wax", "Number", name="string", value="double")
_TYPES: Final[dict[object, str | MessageType]] = {
    bool: "bool",
    int: "int64",
    float: "double",
    dict: _NUMBER,
}
"""The type of each field of an event; anything else is a word."""


def stamp(at_ns: int) -> dict[str, int]:
    """Return a time since 1970 as a message has it."""
    return {"seconds": at_ns // 10**9, "nanos": at_ns % 10**9}


@cache
def message_of(kind: type[TapeEvent]) -> MessageType:
    """Return the message of a kind of event, with its fields in their order."""
    fields = (Field(name, *_type(info.annotation)) for name, info in kind.model_fields.items())
    return MessageType("wax", kind.__name__, tuple(fields))


def values_of(event: TapeEvent) -> dict[str, Any]:
    """Return what `message_of` has of an event; an unknown number is NaN, a gap in a plot."""
    values: dict[str, Any] = {}
    for field in message_of(type(event)).fields:
        value = getattr(event, field.name)
        if isinstance(value, dict):
            value = [{"name": name, "value": number} for name, number in value.items()]
        elif value is None and field.type == "double":
            value = math.nan
        values[field.name] = value
    return values


def pose_of(event: TapeEvent) -> dict[str, Any] | None:
    """Return where the robot is, None where it does not tell, or for another event."""
    if not isinstance(event, Reported) or event.x_m is None or event.y_m is None:
        return None
    half_rad = (event.heading_rad or 0.0) / 2
    return {
        "frame_id": "floor",
        "pose": {
            "position": {"x": event.x_m, "y": event.y_m, "z": 0.0},
            "orientation": {
                "x": 0.0,
                "y": 0.0,
                "z": math.sin(half_rad),
                "w": math.cos(half_rad),
            },
        },
    }


class LogLines:
    """Says in words what changes: what the gate decided, stops, faults and turns.

    Give it the events in order of time.
    """

    def __init__(self) -> None:
        self._gate: str | None = None
        self._newest: dict[type[TapeEvent], TapeEvent] = {}

    def line_of(self, event: TapeEvent) -> dict[str, str] | None:
        """Return a line of the log, None where nothing has changed."""
        if isinstance(event, Steered):
            gate = _gate(event)
            is_news, self._gate = gate != self._gate, gate
            said: _Said | None = "gate", "INFO" if gate == _PASSED else "WARNING", gate
        else:
            # Each part repeats the newest of a kind.
            is_news = self._newest.get(type(event)) != event
            self._newest[type(event)] = event
            said = _said(event)
        if said is None or not is_news:
            return None
        return dict(zip(("name", "level", "message"), said, strict=True))


_PASSED: Final = "passed"


def _gate(event: Steered) -> str:
    if event.reason is not None:
        return f"held: {event.reason}"
    return _PASSED if event.limit is None else f"slowed: {event.limit}"


def _said(event: TapeEvent) -> _Said | None:
    match event:
        case Stopped(pressed=True):
            said = "stop", "WARNING", f"Stop {event.number} is pressed"
        case Stopped():
            said = "stop", "INFO", f"Stop {event.number} is released"
        case Faulted():
            said = "fault", "ERROR", f"stopped while somebody drove: {event.why}"
        case Turned(operator=None):
            said = "turn", "INFO", f"turn {event.number} has ended: {event.why}"
        case Turned():
            said = "turn", "INFO", f"turn {event.number} begins"
        case Tasked():
            said = "task", "INFO", event.text
        case Missed():
            said = "tape", "WARNING", f"nothing was recorded for {event.missed_s:g} s"
        case _:
            return None
    return said


def _type(annotation: Any) -> tuple[str | MessageType, bool]:
    """Return the type of a field, and whether it is repeated."""
    kinds = [one for one in get_args(annotation) if one is not NoneType]
    kind = kinds[0] if len(kinds) == 1 else annotation
    kind = get_origin(kind) or kind
    return _TYPES.get(kind, "string"), kind is dict
