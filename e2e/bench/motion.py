"""What bytes on the serial line mean: when the robot was told to move, and when to stand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from wax.config import BytesDialectSettings

if TYPE_CHECKING:
    from collections.abc import Iterable

    from e2e.bench.serial_line import Piece


@dataclass(frozen=True, slots=True)
class Change:
    """From standing to moving or back, at the byte that says so, on CLOCK_MONOTONIC."""

    at_ms: float
    moving: bool


def changes(pieces: Iterable[Piece]) -> list[Change]:
    """Read the dialect `bytes` with its built-in table; the robot stands at first."""
    table = BytesDialectSettings()
    keep = {table.fine, table.gross}
    found: list[Change] = []
    moving = False
    for piece in pieces:
        for octet in piece.data:
            if octet in keep or (octet != table.stop) is moving:
                continue
            moving = not moving
            found.append(Change(at_ms=piece.at_ms, moving=moving))
    return found
