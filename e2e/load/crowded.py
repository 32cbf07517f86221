"""What a crowd costs the operator: the same minute alone and beside fifty observers."""

from __future__ import annotations

import asyncio
import random
import statistics
import time
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final

from e2e.harness.board import Board
from e2e.load.crowd import Crowd
from e2e.load.fan_out import FPS, received
from e2e.load.key_to_byte import HOLD_S, REST_S, Stroke, changes, delays
from e2e.load.process import two_cores, udp_receive_errors
from e2e.load.servers import WAX, serving
from e2e.measure.age import Ages
from e2e.measure.errors import MeasureError, NotRunError
from e2e.measure.row import Row, judged
from e2e.measure.summary import summarize
from e2e.stop.record import Record
from wax.client import Operator

if TYPE_CHECKING:
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
    fps_min: float = FPS


async def crowded(n: int) -> list[Row]:
    """Drive in `n` pairs of periods, alone and beside the crowd by turns; server on its core."""
    cores = two_cores()
    if cores is None:
        raise NotRunError("the crowd needs two cores and a way to pin processes to them (Linux)")
    alone, beside = await _pairs(n, *cores)
    commands_ms = [
        summarize(crowd.commands_ms).p99 - summarize(one.commands_ms).p99
        for one, crowd in zip(alone, beside, strict=True)
    ]
    pictures_ms = [
        statistics.median(crowd.pictures_ms) - statistics.median(one.pictures_ms)
        for one, crowd in zip(alone, beside, strict=True)
    ]
    crowd = f"{OBSERVERS} observers, {SLOW} of them at 50 kbit/s"

    def row(key: str, what: str, unit: str, value: float, goal: float, **more: Any) -> Row:
        return judged(f"crowd: {key}", what, unit, {WAX: value}, goal, n=n, load=crowd, **more)

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
            detail={"alone": str(summarize([statistics.median(p.pictures_ms) for p in alone]))},
        ),
        row(
            "missing",
            "… packets that any observer with a good link missed",
            "",
            float(sum(one.missing for one in beside)),
            0.0,
            detail={"fps_min": min(one.fps_min for one in beside)},
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


async def _pairs(n: int, server_core: int, crowd_core: int) -> tuple[list[Period], list[Period]]:
    alone, beside = [], []
    with TemporaryDirectory(prefix="wax-bench-") as folder:
        board = Board(Path(folder))
        await board.start()
        robot = {"driver": "serial", "serial": {"url": str(board.path)}}
        try:
            async with serving(WAX, server_core, robot=robot) as server:
                with await asyncio.to_thread(
                    Crowd, server.offering, crowd_core, slow=SLOW
                ) as crowd:
                    for _ in range(n):
                        await asyncio.to_thread(crowd.hold, 0)
                        alone.append(await _period(server, board, None))
                        await asyncio.to_thread(crowd.hold, OBSERVERS)
                        beside.append(await _period(server, board, crowd))
        finally:
            await board.stop()
    return alone, beside


async def _period(server: MeasuredServer, board: Board, crowd: Crowd | None) -> Period:
    ages = Ages()
    async with Operator(server.url, sees=True, on_message=ages.learn) as operator:
        await operator.join()
        operator.let_go()
        await asyncio.sleep(_SETTLE_S)
        found = Period()
        errors = udp_receive_errors()
        first = None if crowd is None else await asyncio.to_thread(crowd.count)
        looking = asyncio.create_task(_look(operator, ages, found))
        strokes = await steer_at_random(operator)
        looking.cancel()
        if crowd is not None and first is not None:
            last = await asyncio.to_thread(crowd.count)
            # A modem carries less than everything.
            first, last = (
                one.model_copy(update={"viewers": one.viewers[SLOW:]}) for one in (first, last)
            )
            found.fps_min, _, found.missing = received(first, last)
        if (thrown := udp_receive_errors() - errors) > 0:
            raise MeasureError(f"the kernel threw away {thrown} datagrams before they were read")
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


async def steer_at_random(operator: Operator) -> list[Stroke]:
    """Press and let go at random phase; what is pressed is sent at once, as by the page."""
    strokes = []
    ends_s = time.monotonic() + _PERIOD_S
    while time.monotonic() < ends_s:
        strokes.append(Stroke(True, time.monotonic() * 1000))
        operator.steer(0.0, 1.0)
        operator.command()
        await asyncio.sleep(random.uniform(*HOLD_S))
        strokes.append(Stroke(False, time.monotonic() * 1000))
        operator.let_go()
        await asyncio.sleep(random.uniform(*REST_S))
    return strokes
