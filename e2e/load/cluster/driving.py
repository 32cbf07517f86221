"""Somebody who drives at the robot's own server meanwhile, whom no fault of a room concerns.

``python -m e2e.load.cluster.driving URL LOG`` is the operator, in a process of its own, so that
nothing that measures makes it late. It turns the robot until its standard input ends; where the
robot stops, it lets go and presses again, as a person does. It writes to LOG when each picture
began to arrive, in seconds of `time.monotonic`, the same in every process here.
"""

from __future__ import annotations

import asyncio
import sys
from asyncio.subprocess import PIPE
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from e2e.harness.wait import eventually
from e2e.load.cluster.page import longest_gap_ms, now_ms, unix_ms
from e2e.load.process import pinned
from e2e.load.strokes import changes
from e2e.measure.row import Row, timed
from e2e.measure.suite import ROOT
from e2e.stop.record import Record
from wax.client.operator import Operator

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Sequence
    from typing import TextIO

    from e2e.load.cluster.stage import Stage
    from e2e.stop.record import Seen

GAP_MS: Final = 100.0
_AFTER_S: Final = 0.5
"""What stands at the end has moved again by then, or the gap has no end."""
_LOOK_S: Final = 0.005
_PRESS_S: Final = 0.1
_AGAIN_S: Final = 0.4
_SWEEP: Final = 100
_SLOWEST: Final = 0.3
_STEP: Final = 0.005


class Bystander:
    """Sums up what comes to an operator, and from them to the board, around each fault."""

    def __init__(self, pictures: Path, record: Record) -> None:
        self._pictures = pictures
        self._record = record
        self._gaps_ms: list[float] = []
        self._stops = 0

    async def moves(self) -> bool:
        """Tell whether the newest command moves the robot."""
        self._record.read()
        return bool(self._record.frames) and self._record.frames[-1].moves

    @asynccontextmanager
    async def beside(self) -> AsyncIterator[None]:
        """Take what there is during the block."""
        from_ms = now_ms()
        yield
        to_ms = now_ms()
        await asyncio.sleep(_AFTER_S)
        self._record.read()
        lines = self._pictures.read_text(encoding="utf-8").split("\n")[:-1]
        came_ms = [unix_ms(float(line)) for line in lines]
        for times_ms in (came_ms, speeds_ms(self._record.frames)):
            self._gaps_ms.append(longest_gap_ms(times_ms, from_ms, to_ms))
        stops_ms = [
            unix_ms(one.at_ms / 1000) for one in changes(self._record.frames) if not one.moving
        ]
        self._stops += sum(from_ms <= at <= to_ms for at in stops_ms)

    def row(self) -> Row:
        """Judge the longest gaps around each fault; a stop is a miss."""
        what = "… meanwhile the operator without a picture, or the board without a new command"
        return timed("room-lost: operator", what, self._gaps_ms, GAP_MS, wrong=self._stops)


def speeds_ms(frames: Sequence[Seen]) -> list[float]:
    """Return when the board was told another speed than before."""
    told: list[float] = []
    before: tuple[int, int] | None = None
    for frame in frames:
        speed = frame.left_mmps, frame.right_mmps
        if frame.taken and speed != before:
            told.append(unix_ms(frame.at_s))
            before = speed
    return told


@asynccontextmanager
async def driving(stage: Stage) -> AsyncIterator[Bystander]:
    """Drive inside the block; raises `AssertionError` if the robot does not move."""
    pictures = stage.folder / "pictures.log"
    pictures.touch()
    with pinned(stage.robots_core):
        process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", "e2e.load.cluster.driving", stage.server.url, str(pictures)),
            stdin=PIPE,
            cwd=ROOT,
        )
    found = Bystander(pictures, Record(stage.board.log_path))
    try:
        await eventually(found.moves, "the operator drives", within_s=20)
        yield found
    finally:
        assert process.stdin is not None
        process.stdin.close()
        await process.wait()


def sweep(seq: int) -> float:
    """Return the share of full speed of this command: up and down, never twice the same."""
    at = seq % (2 * _SWEEP)
    return _SLOWEST + _STEP * min(at, 2 * _SWEEP - at)


class Sweeping(Operator):
    """Turns on the spot, by another speed with every command."""

    def row(self, seq: int, **other: Any) -> str:
        if self.held:
            self.angular = sweep(seq)
        return super().row(seq, **other)


async def _drive(url: str, log: TextIO) -> None:
    moving = [False]

    def heard(message: dict[str, Any]) -> None:
        if message["type"] == "drive_status":
            moving[0] = message["moving"]

    async with Sweeping(url, sees=True, on_message=heard) as operator:
        await operator.join()
        works = (_look(operator, log), _press(operator, moving))
        tasks = [asyncio.create_task(work) for work in works]
        await asyncio.to_thread(sys.stdin.read)
        for task in tasks:
            task.cancel()


async def _press(operator: Operator, moving: Sequence[bool]) -> None:
    """Press whenever the robot stands."""
    while True:
        if not moving[0]:
            operator.let_go()
            await asyncio.sleep(_PRESS_S)
            operator.steer(0.0, _SLOWEST)  # on the spot, where there is no wall
        await asyncio.sleep(_AGAIN_S)


async def _look(operator: Operator, log: TextIO) -> None:
    """Note each picture once."""
    noted_s = 0.0
    while True:
        newest = operator.media.newest("video")
        if newest is not None and newest.at_s > noted_s:
            noted_s = newest.at_s
            log.write(f"{noted_s:.4f}\n")
            log.flush()
        await asyncio.sleep(_LOOK_S)


if __name__ == "__main__":
    with Path(sys.argv[2]).open("w", encoding="utf-8") as file:
        asyncio.run(_drive(sys.argv[1], file))
