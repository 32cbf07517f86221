"""What two states of the room differ in, and the later one made of the earlier one again. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from wax.protocol.messages import RoomChange

if TYPE_CHECKING:
    from wax.protocol.messages import RoomState


def between(before: RoomState, after: RoomState) -> RoomChange:
    """Return the change; its `viewers` are in the order of `after`."""
    known = {line.id: line for line in before.viewers}
    here = {line.id for line in after.viewers}
    return RoomChange(
        **_parts(after)
        | {"viewers": [line for line in after.viewers if known.get(line.id) != line]},
        gone=[number for number in known if number not in here],
    )


def applied(room: dict[str, Any], change: dict[str, Any]) -> dict[str, Any]:
    """Return the room after this change, both as they come over the wire.

    Viewers are in the order of their numbers, which is that of their arrival.
    """
    lines = {line["id"]: line for line in (*room["viewers"], *change["viewers"])}
    for number in change["gone"]:
        lines.pop(number, None)
    rest = {name: value for name, value in change.items() if name != "gone"}
    return rest | {"type": "room", "viewers": [lines[number] for number in sorted(lines)]}


def _parts(room: RoomState) -> dict[str, Any]:
    return {name: value for name, value in room if name != "type"}
