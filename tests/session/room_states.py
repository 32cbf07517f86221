"""States of a room, as pages are told them."""

from __future__ import annotations

from typing import Any

from wax.protocol import messages


def line(number: int, **more: Any) -> messages.ViewerInfo:
    name = more.pop("name", f"Guest {number} of some length"[: messages.MAX_NAME_CHARS])
    return messages.ViewerInfo(id=number, name=name, **more)


def room(*viewers: messages.ViewerInfo, **more: Any) -> messages.RoomState:
    known: dict[str, Any] = {
        "viewers": list(viewers),
        "turn": messages.TurnInfo(number=1, operator=1, ends_server_ms=123_456.7),
        "robot": messages.RobotStatus(connected=True, battery_v=7.4),
    }
    return messages.RoomState(**known | more)
