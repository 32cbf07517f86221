"""From a hand to the robot's line: strokes, the changes that they make, and delays."""

from __future__ import annotations

import asyncio
import random
import time
from bisect import bisect_left
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from e2e.stop.record import Seen
    from wax.client import Operator

REST_S: Final = (0.2, 0.4)
HOLD_S: Final = (0.12, 0.3)


@dataclass(frozen=True, slots=True)
class Stroke:
    """A control that went down or up, by the time stamp of the event; CLOCK_MONOTONIC."""

    down: bool
    made_ms: float


@dataclass(frozen=True, slots=True)
class Change:
    """From standing to moving or back: when the frame was complete; CLOCK_MONOTONIC."""

    at_ms: float
    moving: bool


def changes(frames: Iterable[Seen]) -> list[Change]:
    """Find when the robot was told to move and when to stand; only accepted frames count."""
    found: list[Change] = []
    moving = False
    for frame in frames:
        if frame.taken and frame.kind in {"drive", "move", "stop"} and frame.moves is not moving:
            moving = frame.moves
            found.append(Change(at_ms=frame.at_s * 1000, moving=moving))
    return found


def delays(strokes: Sequence[Stroke], moves: Sequence[Change], *, down: bool) -> list[float]:
    """Return how long after each stroke its effect came, in ms, for those that had one."""
    if not moves:
        raise MeasureError("the robot's line stayed silent")
    times_ms = [move.at_ms for move in moves]
    ends_ms = [stroke.made_ms for stroke in strokes[1:]] + [float("inf")]
    found = []
    for stroke, end_ms in zip(strokes, ends_ms, strict=True):
        if stroke.down is not down:
            continue
        index = bisect_left(times_ms, stroke.made_ms)
        if index < len(moves) and times_ms[index] < end_ms and moves[index].moving is down:
            found.append(times_ms[index] - stroke.made_ms)
    return found


async def steer_at_random(operator: Operator, seconds: float) -> list[Stroke]:
    """Press and release at random phase; each press is sent at once, as by the page."""
    strokes = []
    ends_s = time.monotonic() + seconds
    while time.monotonic() < ends_s:
        strokes.append(Stroke(True, time.monotonic() * 1000))
        operator.steer(0.0, 1.0)
        operator.command()
        await asyncio.sleep(random.uniform(*HOLD_S))
        strokes.append(Stroke(False, time.monotonic() * 1000))
        operator.let_go()
        await asyncio.sleep(random.uniform(*REST_S))
    return strokes
