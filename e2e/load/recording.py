"""What the tape costs: the same drive with recording off and on, by turns."""

from __future__ import annotations

import asyncio
import statistics
import time
from dataclasses import dataclass
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final

from e2e.load.crowd import Crowd
from e2e.load.fan_out import grown
from e2e.load.process import all_received, two_cores
from e2e.load.servers import WAX, serving_board
from e2e.load.strokes import changes, delays, steer_at_random
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, judged
from e2e.measure.summary import summarize
from e2e.stop.record import Record
from wax.client import Operator

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.harness.board import Board
    from e2e.load.servers import MeasuredServer

_SETTLE_S: Final = 6.0
_PERIOD_S: Final = 20.0
_CPU_PERCENT: Final = 3.0
_COMMAND_MS: Final = 2.0


@dataclass(frozen=True, slots=True)
class Drive:
    """One drive: the server's share of a core, and ms from stroke to byte."""

    cpu: float
    commands_ms: list[float]
    left_out: int


async def recording(n: int) -> list[Row]:
    """Drive `n` pairs, each on a server of its own; every second pair begins with the tape on."""
    cores = two_cores()
    drives: dict[bool, list[Drive]] = {False: [], True: []}
    for number in range(n):
        for is_on in (bool(number % 2), not number % 2):
            drives[is_on].append(await _drive(*cores, is_on=is_on))
    return rows(drives[False], drives[True])


def rows(off: Sequence[Drive], on: Sequence[Drive]) -> list[Row]:
    """Compare the pairs' shares of a core, and the strokes of all drives: one has too few."""
    percent = [(taped.cpu - bare.cpu) * 100 for bare, taped in zip(off, on, strict=True)]
    later_ms = _p99_ms(on) - _p99_ms(off)
    left_out = float(sum(drive.left_out for drive in on))

    def row(key: str, what: str, unit: str, value: float, goal: float, **more: Any) -> Row:
        load = "an operator who drives, and a viewer of the top rendition"
        return judged(
            f"recording: {key}", what, unit, {WAX: value}, goal, n=len(on), load=load, **more
        )

    return [
        row(
            "cpu",
            "the tape on: more of the server's CPU",
            "% of a core",
            statistics.median(percent),
            _CPU_PERCENT,
            spread=summarize(percent),
        ),
        row("command", "… stroke → the byte on the line, p99, later", "ms", later_ms, _COMMAND_MS),
        row("left out", "… what did not get onto it", "", left_out, 0.0),
    ]


def _p99_ms(drives: Sequence[Drive]) -> float:
    return summarize([ms for drive in drives for ms in drive.commands_ms]).p99


async def _drive(server_core: int, others_core: int, *, is_on: bool) -> Drive:
    with TemporaryDirectory(prefix="wax-load-") as folder:
        tape = {"enabled": is_on, "folder": f"{folder}/tape", "min_free_gb": 0.0}
        async with serving_board(server_core, recording=tape) as (server, board):
            with await asyncio.to_thread(Crowd, server.offering, others_core) as crowd:
                await asyncio.to_thread(crowd.hold, 1)
                await grown(crowd)
                return await _driven(server, board, is_on=is_on)


async def _driven(server: MeasuredServer, board: Board, *, is_on: bool) -> Drive:
    async with Operator(server.url, sees=True) as operator:
        await operator.join()
        operator.let_go()
        await asyncio.sleep(_SETTLE_S)
        with all_received():
            began_s, began_cpu_s = time.monotonic(), server.meter.cpu_s()
            made = await steer_at_random(operator, _PERIOD_S)
            cpu = (server.meter.cpu_s() - began_cpu_s) / (time.monotonic() - began_s)
        left_out = _left_out((await server.status())["tape"], is_on=is_on)
        await operator.leave()
    record = Record(board.log_path)
    record.read()
    commands_ms = delays(made, changes(record.frames), down=True)
    if not commands_ms:
        raise MeasureError("the operator did not drive")
    return Drive(cpu, commands_ms, left_out)


def _left_out(tape: dict[str, Any] | None, *, is_on: bool) -> int:
    """Return what is not on the tape; raises `MeasureError` if it is not as it was to be."""
    if (tape is not None) is not is_on or (tape and tape["problem"] is not None):
        raise MeasureError(f"the tape is not as it was to be: {tape}")
    return int(tape["left_out"]) if tape else 0
