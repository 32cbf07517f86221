"""States of a room, as pages are told them."""

from __future__ import annotations

from typing import Any

from wax.protocol import messages


def line(number: int, **more: Any) -> messages.ViewerInfo:
    known: dict[str, Any] = {
        "id": number,
        "name": f"Guest {number} of some length"[: messages.MAX_NAME_CHARS],
        "role": "observer",
        "place": None,
        "wait_s": None,
        "lost": False,
        "host": False,
    }
    return messages.ViewerInfo(**known | more)


def room(*viewers: messages.ViewerInfo, **more: Any) -> messages.RoomState:
    known: dict[str, Any] = {
        "viewers": list(viewers),
        "turn": messages.TurnInfo(
            number=1, operator=1, ends_server_ms=123_456.7, stands_left_ms=None
        ),
        "stop": None,
        "robot": messages.RobotStatus(
            connected=True, problem=None, bumpers=0, battery_v=7.4, battery_fraction=None
        ),
        "call": None,
        "host_settings": messages.HostSettings(
            held=False, locked=False, blanked=False, message="", max_fraction=1.0
        ),
        "video": messages.ViewStatus(problem=None),
        "audio": messages.SourceStatus(problem=None),
        "tape": None,
        "aboard": None,
    }
    return messages.RoomState(**known | more)
