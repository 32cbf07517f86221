"""What the board's log means: when the robot was told to move, and when to stand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping


@dataclass(frozen=True, slots=True)
class Change:
    """From standing to moving or back, when the frame that says so was whole; CLOCK_MONOTONIC."""

    at_ms: float
    moving: bool


def changes(log: Iterable[Mapping[str, Any]]) -> list[Change]:
    """Read a board's log; the robot stands at first. Only frames that were taken count."""
    found: list[Change] = []
    moving = False
    for event in log:
        if event["event"] != "frame" or event["verdict"] != "taken":
            continue
        match event["type"]:
            case "drive":
                moves = bool(event["left"] or event["right"])
            case "stop":
                moves = False
            case _:
                continue
        if moves is not moving:
            moving = moves
            found.append(Change(at_ms=event["t_s"] * 1000, moving=moving))
    return found
