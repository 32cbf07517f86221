"""What the tape costs: the same drive with recording off and on, by turns."""

from __future__ import annotations

import asyncio
import statistics
import time
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final

from e2e.harness.board import Board
from e2e.load.crowd import Crowd
from e2e.load.crowded import steer_at_random
from e2e.load.fan_out import grown
from e2e.load.key_to_byte import changes, delays
from e2e.load.process import two_cores, udp_receive_errors
from e2e.load.servers import WAX, serving
from e2e.measure.errors import MeasureError, NotRunError
from e2e.measure.row import Row, judged
from e2e.measure.summary import summarize
from e2e.stop.record import Record
from wax.client import Operator

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.load.servers import MeasuredServer

_SETTLE_S: Final = 8.0
_CPU_PERCENT: Final = 3.0
_COMMAND_MS: Final = 2.0
_SERVED: Final = "an operator who drives, and a viewer of the top rendition"


@dataclass(frozen=True, slots=True)
class Drive:
    """One drive: the server's share of a core, and ms from stroke to byte."""

    cpu: float
    commands_ms: list[float]
    left_out: int


async def recording(n: int) -> list[Row]:
    """Drive `n` pairs, each on a server of its own; every second pair begins with the tape on."""
    cores = two_cores()
    if cores is None:
        raise NotRunError("this needs two cores and a way to pin processes to them (Linux)")
    drives: dict[bool, list[Drive]] = {False: [], True: []}
    for number in range(n):
        for is_on in (bool(number % 2), not number % 2):
            drives[is_on].append(await _drive(*cores, is_on=is_on))
    return rows_of(drives[False], drives[True])


def rows_of(off: Sequence[Drive], on: Sequence[Drive]) -> list[Row]:
    """Compare the pairs' shares of a core, and the strokes of all drives: one has too few."""
    n = len(on)
    cpu_percent = [
        (with_tape.cpu - without.cpu) * 100 for without, with_tape in zip(off, on, strict=True)
    ]
    commands = {
        name: summarize([ms for drive in drives for ms in drive.commands_ms])
        for name, drives in (("off", off), ("on", on))
    }

    def row(key: str, what: str, unit: str, value: float, goal: float, **more: Any) -> Row:
        return judged(
            f"recording: {key}", what, unit, {WAX: value}, goal, n=n, load=_SERVED, **more
        )

    return [
        row(
            "cpu",
            "the tape on: more of the server's CPU",
            "% of a core",
            statistics.median(cpu_percent),
            _CPU_PERCENT,
            spread=summarize(cpu_percent),
            detail={"off": str(summarize([drive.cpu * 100 for drive in off]))},
        ),
        row(
            "command",
            "… stroke → the byte on the line, p99, later",
            "ms",
            commands["on"].p99 - commands["off"].p99,
            _COMMAND_MS,
            detail={name: str(spread) for name, spread in commands.items()},
        ),
        row(
            "left out",
            "… what did not get onto it",
            "",
            float(sum(drive.left_out for drive in on)),
            0.0,
        ),
    ]


async def _drive(server_core: int, others_core: int, *, is_on: bool) -> Drive:
    with TemporaryDirectory(prefix="wax-bench-") as folder:
        board = Board(Path(folder))
        await board.start()
        robot = {"driver": "serial", "serial": {"url": str(board.path)}}
        tape = {"enabled": is_on, "folder": f"{folder}/tape", "min_free_gb": 0.0}
        try:
            async with serving(WAX, server_core, robot=robot, recording=tape) as server:
                with await asyncio.to_thread(Crowd, server.offering, others_core) as crowd:
                    await asyncio.to_thread(crowd.hold, 1)
                    await grown(crowd)
                    return await _driven(server, board, is_on=is_on)
        finally:
            await board.stop()


async def _driven(server: MeasuredServer, board: Board, *, is_on: bool) -> Drive:
    async with Operator(server.url, sees=True) as operator:
        await operator.join()
        operator.let_go()
        await asyncio.sleep(_SETTLE_S)
        errors, began_s, began_cpu_s = udp_receive_errors(), time.monotonic(), server.meter.cpu_s()
        made = await steer_at_random(operator)
        cpu = (server.meter.cpu_s() - began_cpu_s) / (time.monotonic() - began_s)
        if (thrown := udp_receive_errors() - errors) > 0:
            raise MeasureError(f"the kernel threw away {thrown} datagrams before they were read")
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
    if tape is None:
        if is_on:
            raise MeasureError("nothing is recorded")
        return 0
    if not is_on or tape["problem"] is not None:
        raise MeasureError(f"the tape is not as it was to be: {tape}")
    return int(tape["left_out"])
