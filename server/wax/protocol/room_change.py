"""Diffs two states of the room, and applies such a change. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from wax.protocol.messages import RoomChange

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.protocol.messages import RoomState, ViewerInfo

PARTS: Final = tuple(RoomChange.model_fields.keys() - {"type", "viewers", "gone"})
"""The parts that a change may leave out."""
_ABSENT: Final = dict.fromkeys(PARTS)


def between(before: RoomState, after: RoomState) -> RoomChange:
    """Return the change from `before` to `after`; its `viewers` are in the order of `after`."""
    known = {line.id: line for line in before.viewers}
    here = {line.id for line in after.viewers}
    changed = {
        name: part for name in PARTS if (part := getattr(after, name)) != getattr(before, name)
    }
    lines = [line for line in after.viewers if known.get(line.id) != line]
    return of_lines(lines, [number for number in known if number not in here], **changed)


def of_lines(viewers: list[ViewerInfo], gone: Sequence[int] = (), **parts: Any) -> RoomChange:
    """Return a change of these lines and parts; it lacks all others."""
    # Without values for all, pydantic copies the defaults deeply, at each change.
    return RoomChange.model_construct(
        {"viewers", "gone", *parts}, viewers=viewers, gone=list(gone), **(_ABSENT | parts)
    )


def text_of(update: RoomState | RoomChange) -> str:
    """Return the message's JSON, without unchanged parts."""
    if not isinstance(update, RoomChange):
        return update.model_dump_json()
    return update.model_dump_json(exclude=set(PARTS) - update.model_fields_set)


def applied(room: dict[str, Any], change: dict[str, Any]) -> dict[str, Any]:
    """Return the room after this change, both as decoded from the wire.

    Viewers are in the order of their numbers, which is the order of arrival.
    """
    lines = {line["id"]: line for line in (*room["viewers"], *change["viewers"])}
    for number in change["gone"]:
        lines.pop(number, None)
    rest = {name: value for name, value in change.items() if name != "gone"}
    return {**room, **rest, "type": "room", "viewers": [lines[one] for one in sorted(lines)]}
