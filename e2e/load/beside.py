"""What a crowd, and the tape, cost the operator: the same drive with and without it, in turn."""

from __future__ import annotations

import asyncio
import statistics
import time
from dataclasses import dataclass, field
from functools import partial
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final

from e2e.load.crowd.crowd import gathered
from e2e.load.fan_out import grown
from e2e.load.process import all_received, two_cores
from e2e.load.servers import serving_board
from e2e.load.strokes import changes, delays, steer_at_random
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, middle, summarize
from e2e.stop.record import Record
from wax.client import Operator

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.harness.board import Board
    from e2e.load.servers import MeasuredServer

OBSERVERS: Final = 50
"""More do not fit on the other core together with the measuring process."""
SLOW: Final = 5
"""These observers are behind a modem each."""
CROWD: Final = f"{OBSERVERS} observers, {SLOW} of them at 50 kbit/s"
_SETTLE_S: Final = 6.0
_LOOK_S: Final = 0.02


@dataclass(slots=True)
class Drive:
    """One drive: ms from key to byte, ms of the picture's age on arrival, and its cost.

    `cpu` is the server's share of a core, `left_out` what the tape left out.
    """

    commands_ms: list[float]
    pictures_ms: list[float] = field(default_factory=lambda: [0.0])
    cpu: float = 0.0
    beat_p99_ms: float = 0.0
    beat_gap_ms: float = 0.0
    left_out: int = 0


Pairs = list[tuple[Drive, Drive]]
"""Pairs of drives without and with what is compared."""


async def crowded(n: int) -> list[Row]:
    """Drive in `n` pairs alone and with the crowd; every second pair starts with the crowd."""
    server_core, crowd_core = two_cores()
    pairs: Pairs = []
    async with (
        serving_board(server_core) as (server, board),
        gathered(server.offering, crowd_core, slow=SLOW) as crowd,
    ):
        for number in range(n):
            found = {}
            for is_beside in (bool(number % 2), not number % 2):
                await crowd.hold(OBSERVERS if is_beside else 0)
                found[is_beside] = await _drive(server, board, seconds=30.0)
            pairs.append((found[False], found[True]))
    return crowd_rows(pairs)


def crowd_rows(pairs: Pairs) -> list[Row]:
    """Compare pair by pair; of the control loop's beat the worst counts."""
    commands_ms = [_p99_ms([beside]) - _p99_ms([alone]) for alone, beside in pairs]
    pictures_ms = [
        statistics.median(beside.pictures_ms) - statistics.median(alone.pictures_ms)
        for alone, beside in pairs
    ]
    beside = [one for _, one in pairs]
    what = f"stroke → the byte on the line, p99, later beside {CROWD}"
    older = "… and the operator's picture on arrival, p50, older"
    beat = "… the control loop's beat, p99 of the last minute, worst"
    worst_ms = max(one.beat_p99_ms for one in beside)
    latest_ms = max(one.beat_gap_ms for one in beside)
    row = partial(middle, n=len(pairs))
    return [
        row("crowd: command", what, "ms", commands_ms, 5.0),
        row("crowd: picture", older, "ms", pictures_ms, 5.0),
        row("crowd: beat p99", beat, "ms", [worst_ms], 5.0),
        row("crowd: beat gap", "… the latest beat of all", "ms", [latest_ms], 40.0),
    ]


async def recording(n: int) -> list[Row]:
    """Drive `n` pairs, each on a server of its own; every second pair starts with the tape on."""
    pairs: Pairs = []
    for number in range(n):
        found = {is_on: await _taped(is_on=is_on) for is_on in (bool(number % 2), not number % 2)}
        pairs.append((found[False], found[True]))
    return tape_rows(pairs)


def tape_rows(pairs: Pairs) -> list[Row]:
    """Compare the pairs' shares of a core, and the strokes of all drives: one drive has too few."""
    percent = [(on.cpu - off.cpu) * 100 for off, on in pairs]
    off, on = ([pair[at] for pair in pairs] for at in (0, 1))
    later_ms = _p99_ms(on) - _p99_ms(off)
    left_out = float(sum(one.left_out for one in on))
    what = "the tape on, an operator and a viewer: more of the server's CPU"
    later = "… stroke → the byte on the line, p99, later"
    row = partial(middle, n=len(pairs))
    return [
        row("recording: cpu", what, "% of a core", percent, 3.0),
        row("recording: command", later, "ms", [later_ms], 2.0),
        row("recording: left out", "… what did not get onto it", "", [left_out], 0.0),
    ]


def _p99_ms(drives: Sequence[Drive]) -> float:
    return summarize([ms for drive in drives for ms in drive.commands_ms]).p99


async def _taped(*, is_on: bool) -> Drive:
    server_core, others_core = two_cores()
    with TemporaryDirectory(prefix="wax-load-") as folder:
        tape = {"enabled": is_on, "folder": f"{folder}/tape", "min_free_gb": 0.0}
        async with (
            serving_board(server_core, recording=tape) as (server, board),
            gathered(server.offering, others_core) as crowd,
        ):
            await crowd.hold(1)
            await grown(crowd)
            found = await _drive(server, board, seconds=20.0)
            told = (await server.status())["tape"]
    if (told is not None) is not is_on or (told and told["problem"] is not None):
        raise MeasureError(f"the tape is not as it was to be: {told}")
    found.left_out = int(told["left_out"]) if told else 0
    return found


async def _drive(server: MeasuredServer, board: Board, *, seconds: float) -> Drive:
    """Drive; raises `MeasureError` if the robot does not move, or no picture arrives."""
    pictures_ms = list[float]()
    async with Operator(server.url, sees=True) as operator:
        await operator.join()
        operator.let_go()
        await asyncio.sleep(_SETTLE_S)
        with all_received():
            looking = asyncio.create_task(_look(operator, pictures_ms))
            began_s, began_cpu_s = time.monotonic(), server.meter.cpu_s()
            strokes = await steer_at_random(operator, seconds)
            cpu = (server.meter.cpu_s() - began_cpu_s) / (time.monotonic() - began_s)
            looking.cancel()
        counters: dict[str, Any] = (await server.status())["counters"]
        await operator.leave()
    record = Record(board.log_path)
    record.read()
    commands_ms = delays(strokes, changes(record.frames), down=True)
    if not commands_ms or not pictures_ms:
        raise MeasureError("the operator did not drive, or saw nothing")
    return Drive(
        commands_ms=commands_ms,
        pictures_ms=pictures_ms,
        cpu=cpu,
        beat_p99_ms=float(counters["control.jitter_p99_ms"]),
        beat_gap_ms=float(counters["control.latest_ms"]),
    )


async def _look(operator: Operator, pictures_ms: list[float]) -> None:
    """Note the age of each picture once."""
    seen = None
    while True:
        newest, age_ms = operator.media.newest("video"), operator.age_ms("video")
        if newest is not None and age_ms is not None and newest.rtp != seen:
            seen = newest.rtp
            pictures_ms.append(age_ms)
        await asyncio.sleep(_LOOK_S)
