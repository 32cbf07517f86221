"""What a crowd costs the operator: the same half minute alone and beside fifty observers."""

from __future__ import annotations

import asyncio
import statistics
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from e2e.load.crowd import Crowd
from e2e.load.fan_out import received
from e2e.load.process import all_received, two_cores
from e2e.load.servers import WAX, serving_board
from e2e.load.strokes import changes, delays, steer_at_random
from e2e.measure.age import Ages
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, judged
from e2e.measure.summary import summarize
from e2e.stop.record import Record
from wax.client import Operator

if TYPE_CHECKING:
    from e2e.harness.board import Board
    from e2e.load.servers import MeasuredServer

OBSERVERS: Final = 50
"""More do not fit on the other core together with whoever measures."""
SLOW: Final = 5
"""Behind a modem each."""
_PERIOD_S: Final = 30.0
_SETTLE_S: Final = 8.0
_LOOK_S: Final = 0.02
_COMMAND_MS: Final = 5.0
_PICTURE_MS: Final = 5.0
_BEAT_P99_MS: Final = 5.0
_BEAT_GAP_MS: Final = 40.0


@dataclass(slots=True)
class Period:
    """One period, alone or not: ms from stroke to byte, and of the picture's age on arrival."""

    commands_ms: list[float] = field(default_factory=list)
    pictures_ms: list[float] = field(default_factory=list)
    beat_p99_ms: float = 0.0
    beat_gap_ms: float = 0.0
    missing: int = 0


async def crowded(n: int) -> list[Row]:
    """Drive in `n` pairs of periods, every second one beside the crowd first."""
    server_core, crowd_core = two_cores()
    alone: list[Period] = []
    beside: list[Period] = []
    async with serving_board(server_core) as (server, board):
        with await asyncio.to_thread(Crowd, server.offering, crowd_core, slow=SLOW) as crowd:
            for number in range(n):
                for is_beside in (bool(number % 2), not number % 2):
                    await asyncio.to_thread(crowd.hold, OBSERVERS if is_beside else 0)
                    found = await _period(server, board, crowd if is_beside else None)
                    (beside if is_beside else alone).append(found)
    return rows(alone, beside)


def rows(alone: list[Period], beside: list[Period]) -> list[Row]:
    """Compare pair by pair; of the beat the worst counts."""
    pairs = list(zip(alone, beside, strict=True))
    commands_ms = [
        summarize(crowd.commands_ms).p99 - summarize(one.commands_ms).p99 for one, crowd in pairs
    ]
    pictures_ms = [
        statistics.median(crowd.pictures_ms) - statistics.median(one.pictures_ms)
        for one, crowd in pairs
    ]
    crowd = f"{OBSERVERS} observers, {SLOW} of them at 50 kbit/s"

    def row(key: str, what: str, unit: str, value: float, goal: float, **more: Any) -> Row:
        values = {WAX: value}
        return judged(f"crowd: {key}", what, unit, values, goal, n=len(pairs), load=crowd, **more)

    return [
        row(
            "command",
            f"stroke → the byte on the line, p99, later beside {crowd}",
            "ms",
            statistics.median(commands_ms),
            _COMMAND_MS,
            spread=summarize(commands_ms),
        ),
        row(
            "picture",
            "… and the operator's picture on arrival, p50, older",
            "ms",
            statistics.median(pictures_ms),
            _PICTURE_MS,
            spread=summarize(pictures_ms),
        ),
        row(
            "missing",
            "… packets that any observer with a good link missed",
            "",
            float(sum(one.missing for one in beside)),
            0.0,
        ),
        row(
            "beat p99",
            "… the control loop's beat, p99 of the last minute, worst",
            "ms",
            max(one.beat_p99_ms for one in beside),
            _BEAT_P99_MS,
        ),
        row(
            "beat gap",
            "… the latest beat of all",
            "ms",
            max(one.beat_gap_ms for one in beside),
            _BEAT_GAP_MS,
        ),
    ]


async def _period(server: MeasuredServer, board: Board, crowd: Crowd | None) -> Period:
    ages, found = Ages(), Period()
    async with Operator(server.url, sees=True, on_message=ages.learn) as operator:
        await operator.join()
        operator.let_go()
        await asyncio.sleep(_SETTLE_S)
        with all_received():
            first = None if crowd is None else await asyncio.to_thread(crowd.count)
            looking = asyncio.create_task(_look(operator, ages, found))
            strokes = await steer_at_random(operator, _PERIOD_S)
            looking.cancel()
            if crowd is not None and first is not None:
                # A modem carries less than everything.
                *_, found.missing = received(first, await asyncio.to_thread(crowd.count), SLOW)
        counters = (await server.status())["counters"]
        found.beat_p99_ms = float(counters["control.jitter_p99_ms"])
        found.beat_gap_ms = float(counters["control.latest_ms"])
        await operator.leave()
    record = Record(board.log_path)
    record.read()
    found.commands_ms = delays(strokes, changes(record.frames), down=True)
    if not found.commands_ms or not found.pictures_ms:
        raise MeasureError("the operator did not drive, or saw nothing")
    return found


async def _look(operator: Operator, ages: Ages, found: Period) -> None:
    """Note the age of each picture once."""
    seen = None
    while True:
        newest, age_ms = operator.media.newest("video"), ages.age_ms(operator, "video")
        if newest is not None and age_ms is not None and newest.rtp != seen:
            seen = newest.rtp
            found.pictures_ms.append(age_ms)
        await asyncio.sleep(_LOOK_S)
