"""Somebody who drives at the robot's own server meanwhile, and what reaches both ends of that."""

from __future__ import annotations

import asyncio
import sys
from asyncio.subprocess import PIPE
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from e2e.harness.wait import eventually
from e2e.load.cluster.page import longest_gap_ms, unix_ms
from e2e.load.process import pinned
from e2e.measure.suite import ROOT
from e2e.stop.record import Record

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import AsyncIterator, Sequence
    from pathlib import Path

    from e2e.load.cluster.stage import Stage
    from e2e.stop.record import Seen


class Driving:
    """Reads both logs: the operator's of pictures, the board's of commands. Times are Unix ms."""

    def __init__(self, process: Process, pictures: Path, record: Record) -> None:
        self._process = process
        self._pictures = pictures
        self._record = record

    def call(self, name: str) -> None:
        """Have the operator call themselves so."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{name}\n".encode())

    async def moves(self) -> bool:
        """Tell whether the newest command moves the robot."""
        self._record.read()
        return bool(self._record.frames) and self._record.frames[-1].moves

    def picture_gap_ms(self, from_ms: float, to_ms: float) -> float:
        """Return the longest time without a picture for the operator."""
        came_ms = [unix_ms(float(line)) for line in self._lines() if line[0].isdigit()]
        return longest_gap_ms(came_ms, from_ms, to_ms)

    def command_gap_ms(self, from_ms: float, to_ms: float) -> float:
        """Return the longest time for which the board was told the same speed."""
        self._record.read()
        return longest_gap_ms(changes_ms(self._record.frames), from_ms, to_ms)

    def reasons(self) -> list[str]:
        """Return why the robot stopped, each time since the begin."""
        return [line for line in self._lines() if not line[0].isdigit()]

    def _lines(self) -> list[str]:
        return self._pictures.read_text(encoding="utf-8").split("\n")[:-1]

    def stops(self, from_ms: float, to_ms: float) -> int:
        """Count how often the robot was told to stand."""
        self._record.read()
        return stops(self._record.frames, from_ms, to_ms)


def changes_ms(frames: Sequence[Seen]) -> list[float]:
    """Return when the board was told another speed than before."""
    told: list[float] = []
    before: tuple[int, int] | None = None
    for frame in frames:
        speed = frame.left_mmps, frame.right_mmps
        if frame.taken and speed != before:
            told.append(unix_ms(frame.at_s))
            before = speed
    return told


def stops(frames: Sequence[Seen], from_ms: float, to_ms: float) -> int:
    """Count the frames that stop a robot which moved, in this time."""
    found, moved = 0, False
    for frame in frames:
        if not frame.taken:
            continue
        if moved and not frame.moves and from_ms <= unix_ms(frame.at_s) <= to_ms:
            found += 1
        moved = frame.moves
    return found


@asynccontextmanager
async def driving(stage: Stage) -> AsyncIterator[Driving]:
    """Drive inside the block; raises `AssertionError` if the robot does not move."""
    pictures = stage.folder / "pictures.log"
    pictures.touch()
    with pinned(stage.robots_core):
        process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", "e2e.load.cluster.driver", stage.server.url, str(pictures)),
            stdin=PIPE,
            cwd=ROOT,
        )
    found = Driving(process, pictures, Record(stage.board.log_path))
    try:
        await eventually(found.moves, "the operator drives", within_s=20)
        yield found
    finally:
        assert process.stdin is not None
        process.stdin.close()
        await process.wait()
