"""An operator on the robot's own server, whom no fault of a room may affect.

``python -m e2e.load.cluster.driving URL`` is the operator, in a process of its own, so that no
measurement delays it. It turns the robot until its standard input ends; when the robot stops, it
releases and presses again, as a person does.
"""

from __future__ import annotations

import asyncio
import sys
from contextlib import AsyncExitStack, asynccontextmanager
from typing import TYPE_CHECKING, Any, Final

from e2e.harness.child import child
from e2e.harness.page_clock import unix_ms
from e2e.harness.wait import until
from e2e.load.cluster.page import longest_gap_ms, now_ms
from e2e.load.process import pinned
from e2e.load.strokes import changes
from e2e.measure.row import Row, timed
from e2e.stop.record import Record
from wax.client.operator import Operator

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Sequence

    from e2e.load.cluster.stage import Stage
    from e2e.stop.record import Seen

GAP_MS: Final = 100.0
_AFTER_S: Final = 0.5
"""By then a command has arrived that is newer than the block."""
_PRESS_S: Final = 0.1
_AGAIN_S: Final = 0.4
_LEAVES_S: Final = 10.0
_SWEEP: Final = 100
_SLOWEST: Final = 0.3
_STEP: Final = 0.005


class Bystander:
    """Sums up which of the operator's commands reached the board around each fault."""

    def __init__(self, record: Record) -> None:
        self._record = record
        self._gaps_ms: list[float] = []
        self._stops = 0

    def moves(self) -> bool:
        """Whether the newest command moves the robot."""
        self._record.read()
        return bool(self._record.frames) and self._record.frames[-1].moves

    @asynccontextmanager
    async def beside(self) -> AsyncIterator[None]:
        """Record what happens during the block."""
        from_ms = now_ms()
        yield
        to_ms = now_ms()
        await asyncio.sleep(_AFTER_S)
        await until(self.moves, "the robot moves again")
        frames = self._record.frames
        self._gaps_ms.append(longest_gap_ms(speeds_ms(frames), from_ms, to_ms))
        stops_ms = [unix_ms(one.at_ms / 1000) for one in changes(frames) if not one.moving]
        self._stops += sum(from_ms <= at <= to_ms for at in stops_ms)

    def row(self) -> Row:
        """Judge the longest gap around each fault; a stop, also for an old picture, is a miss."""
        what = "… meanwhile the board without a new command of the operator, who is never stopped"
        return timed("room-lost: operator", what, self._gaps_ms, GAP_MS, wrong=self._stops)


def speeds_ms(frames: Sequence[Seen]) -> list[float]:
    """Return when the board was given a new speed."""
    told: list[float] = []
    before: tuple[int, ...] | None = None
    for frame in frames:
        if frame.taken and frame.speeds != before:
            told.append(unix_ms(frame.at_s))
            before = frame.speeds
    return told


@asynccontextmanager
async def driving(stage: Stage) -> AsyncIterator[Bystander]:
    """Drive inside the block; raises `AssertionError` if the robot does not move."""
    async with AsyncExitStack() as leaving:
        with pinned(stage.robots_core):
            operator = child("e2e.load.cluster.driving", stage.server.url, leaves_s=_LEAVES_S)
            await leaving.enter_async_context(operator)
        found = Bystander(Record(stage.board.log_path))
        await until(found.moves, "the operator drives", within_s=20)
        yield found


def sweep(seq: int) -> float:
    """Return this command's share of full speed: up and down, never the same twice in a row."""
    at = seq % (2 * _SWEEP)
    return _SLOWEST + _STEP * min(at, 2 * _SWEEP - at)


class Sweeping(Operator):
    """Turns on the spot, where there is no wall, at another speed with every command."""

    def row(self, seq: int, **other: Any) -> str:
        if self.held:
            self.angular = sweep(seq)
        return super().row(seq, **other)

    async def press(self) -> None:
        """Press whenever the robot stands."""
        await self.join()
        while True:
            if not self.newest("drive_status").get("moving"):
                self.let_go()
                await asyncio.sleep(_PRESS_S)
                self.steer(0.0, _SLOWEST)
            await asyncio.sleep(_AGAIN_S)


async def _drive(url: str) -> None:
    async with Sweeping(url, sees=True) as operator:
        task = asyncio.create_task(operator.press())
        await asyncio.to_thread(sys.stdin.read)
        task.cancel()


if __name__ == "__main__":
    asyncio.run(_drive(sys.argv[1]))
