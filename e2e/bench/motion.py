"""What the frames on the serial line mean: when the robot was told to move, and when to stand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from wax.robot.serial.frames import Decoder, Drive, Stop

if TYPE_CHECKING:
    from collections.abc import Iterable

    from e2e.bench.serial_line import Piece


@dataclass(frozen=True, slots=True)
class Change:
    """From standing to moving or back, when the frame that says so was whole; CLOCK_MONOTONIC."""

    at_ms: float
    moving: bool


def changes(pieces: Iterable[Piece]) -> list[Change]:
    """Read the dialect ``frames`` as a board does; the robot stands at first."""
    decoder = Decoder()
    found: list[Change] = []
    moving = False
    for piece in pieces:
        for frame in decoder.feed(piece.data):
            match frame.body:
                case Drive(left_mmps, right_mmps):
                    moves = bool(left_mmps or right_mmps)
                case Stop():
                    moves = False
                case _:
                    continue
            if moves is not moving:
                moving = moves
                found.append(Change(at_ms=piece.at_ms, moving=moving))
    return found
