"""The black channel: the eight errors of IEC 61784-3, applied to drive, stop and release."""

from __future__ import annotations

import asyncio
from collections import Counter
from itertools import islice
from random import Random
from typing import TYPE_CHECKING, Any, Final

from e2e.measure.errors import MeasureError
from e2e.measure.row import counted
from e2e.stop.harm import Channel
from e2e.stop.harm_drive import DriveHarm
from e2e.stop.harm_latch import LatchHarm
from e2e.stop.operator import RawOperator
from e2e.stop.stage import STOPS_AT_EACH_TRIAL, staged

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from e2e.measure.row import Row

    Cell = tuple[str, str]

ERRORS: Final = (
    "corruption",
    "repetition",
    "wrong order",
    "loss",
    "delay",
    "insertion",
    "masquerade",
    "wrong address",
)
_ROOM_S: Final = {"drive": 0.04, "stop": 0.2, "release": 0.2}
"""The server reads a hundred messages a second of the one channel, and twenty of the other."""
CELLS: Final = tuple((error, kind) for error in ERRORS for kind in _ROOM_S)


async def black_channel(n: int, *, cells: Sequence[Cell] = CELLS, **settings: Any) -> list[Row]:
    """Inject `n` errors among correct messages, over real data channels.

    Raises `MeasureError` where the server did not read all of them.
    """
    random = Random(2004)
    done: Counter[str] = Counter()
    wrong: Counter[str] = Counter()
    async with (
        staged(STOPS_AT_EACH_TRIAL, **settings) as stage,
        RawOperator(stage.server) as operator,
        RawOperator(stage.server) as stranger,
    ):
        await operator.join()
        # A second turn, so that there is an old one.
        await operator.leave()
        await operator.join()
        channel = Channel(stage, operator, stranger, random)
        drive, latch = DriveHarm(channel), LatchHarm(channel)
        by_kind = {"drive": drive.drive, "stop": latch.stop, "release": latch.release}
        await stage.drive(operator)
        for error, kind in islice(_in_rounds(cells, random), n):
            name = f"{kind}: {error}"
            done[name] += 1
            wrong[name] += await by_kind[kind](error)
            await asyncio.sleep(_ROOM_S[kind] * random.uniform(0.8, 1.2))
            wrong[name] += drive.went_back()
        await asyncio.sleep(0.3)
        wrong["after the last"] += drive.went_back()
        right = sum(frame.moves for frame in stage.record.frames)
        counters = (await stage.server.status())["counters"]
    if counters.get("messages over the rate"):
        raise MeasureError("black-channel: the server did not read all that was sent")
    return [
        counted(
            "black-channel",
            "wrong executions of drive, stop and release over a real data channel",
            wrong.total(),
            n,
            by_error=dict(done),
            wrong_by_error=dict(+wrong),
            refused={name: count for name, count in counters.items() if "refused" in name},
            right_frames=right,
            pressed_anew=drive.pressed_anew,
        )
    ]


def _in_rounds(cells: Sequence[Cell], random: Random) -> Iterator[Cell]:
    """Give each as often as the others, in no order."""
    while True:
        yield from random.sample(cells, len(cells))
