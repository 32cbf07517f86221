"""What guests read of a fault: what it means for them. Only the host reads the details. Pure.

A fault's sentence names ports, files, addresses, and what to change in the configuration; a
plug-in's may say anything. A guest can do nothing with that and need not know it, so guests read
only the sentences that are listed here, and one plain sentence in place of any other.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, TypeVar

from wax.protocol.messages import DriveStatus, Heard, Notice, RoomChange, RoomState
from wax.sentence import Sentence

if TYPE_CHECKING:
    from pydantic import BaseModel

_Message = TypeVar("_Message", bound="BaseModel")

_AREAS: Final = frozenset({"aboard", "control", "drive", "gauge", "hold", "limit", "stop", "voice"})
"""Sentences about the rules of driving are for everybody."""

_CODES: Final = frozenset(
    {
        *("robot.not_connected", "robot.no_answer", "robot.lent"),
        *("robot.held", "robot.server_silent", "robot.garbled"),
        *("camera.none", "media.starting", "speaker.opening", "speaker.silent"),
    }
)

_AROUND: Final = frozenset({"camera.named", "tape.stands", "tape.kept_but"})
"""Sentences for everybody that quote another, which may not be."""

_ROBOT: Final = Sentence("robot.trouble")
_UNDATED: Final = Sentence("drive.undated")
_CAMERA: Final = Sentence("camera.trouble")
_MICROPHONE: Final = Sentence("microphone.trouble")
_SPEAKER: Final = Sentence("speaker.silent")
_TAPE: Final = Sentence("tape.trouble")


def for_guests(message: _Message) -> _Message:
    """Return the message without the details of faults."""
    return message.model_copy(update=_hiding(message))


def _hiding(message: BaseModel) -> dict[str, Any]:
    """Return the fields to replace."""
    match message:
        case RoomState() | RoomChange():
            return _parts(message)
        case DriveStatus(reason=Sentence() as reason):
            return {"reason": _plain(reason, _ROBOT)}
        case Heard(reason=Sentence() as reason):
            return {"reason": _plain(reason, _SPEAKER)}
        case Notice(text=Sentence() as text) if text.code in _AROUND:
            return {"text": _plain(text, _TAPE)}
    return {}


def _parts(room: RoomState | RoomChange) -> dict[str, Any]:
    """Return the parts that may have faults, without details; of a change those that it has."""
    told = room.model_fields_set
    parts: dict[str, Any] = {
        name: _part(getattr(room, name), instead)
        for name, instead in (
            *(("robot", _ROBOT), ("video", _CAMERA)),
            *(("audio", _MICROPHONE), ("voice", _SPEAKER)),
        )
        if name in told
    }
    if "cameras" in told:
        parts["cameras"] = [_part(one, _CAMERA) for one in room.cameras]
    if "tape" in told and room.tape is not None and not room.tape.running:
        parts["tape"] = room.tape.model_copy(update={"why": _plain(room.tape.why, _TAPE)})
    return parts


def _part(part: Any, instead: Sentence) -> Any:
    """Return a part of the room with `instead` in place of its problem's details."""
    if part is None:
        return part
    told: dict[str, Any] = {}
    if part.problem is not None:
        told["problem"] = _plain(part.problem, instead)
    if getattr(part, "undated", None) is not None:
        told["undated"] = _UNDATED
    return part.model_copy(update=told) if told else part


def _plain(sentence: Sentence, instead: Sentence) -> Sentence:
    if sentence.code in _CODES or sentence.code.split(".")[0] in _AREAS:
        return sentence
    if sentence.code not in _AROUND:
        return instead
    values = {
        name: _plain(value, instead) if isinstance(value, Sentence) else value
        for name, value in sentence.values.items()
    }
    return replace(sentence, values=values)
