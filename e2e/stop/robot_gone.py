"""A neighbour of the robot is gone: the driver's process, or the serial line."""

from __future__ import annotations

import asyncio
import os
import signal
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from e2e.harness.wait import eventually
from e2e.measure.row import counted, timed
from e2e.stop.operator import RawOperator
from e2e.stop.page import chromiums
from e2e.stop.stage import random_phase, staged
from e2e.stop.trials import repeat, told
from wax.sentence import Sentence

if TYPE_CHECKING:
    from e2e.measure.row import Row
    from e2e.stop.record import Stopping
    from e2e.stop.stage import Stage

FOR_GUESTS: Final = str(Sentence("robot.trouble"))
GOAL_MS: Final = 250.0
SAID_MS: Final = 500.0
BACK_MS: Final = 2000.0
_LOOK_S: Final = 0.4
_HELD_ON_S: Final = 0.5
"""How long a key stays held after the line has come back: nothing may move because of it."""


async def driver_killed(n: int, **settings: Any) -> Row:
    """Time from SIGKILL to the driver's process: only the board can stop the robot."""
    async with staged(**settings) as stage, RawOperator(stage.server) as operator:
        await operator.join()

        async def trial() -> Stopping | None:
            await stage.answers()
            await stage.drive(operator)
            pid = stage.driver_pid
            await random_phase()
            since_s = time.monotonic()
            os.kill(pid, signal.SIGKILL)
            await asyncio.sleep(_LOOK_S)
            until_s = time.monotonic()
            # The new process starts from neutral, although the control is still held down.
            return stage.outcome(since_s, until_s)

        trials = await repeat("driver-killed", n, trial)
    what = "driver's process killed → the board stops by itself"
    return told("driver-killed", what, trials, GOAL_MS, by_board=True)


async def _problem(stage: Stage) -> None:
    """Wait for the server's message about the robot."""

    async def problem() -> str:
        return str((await stage.server.status())["robot"]["problem"] or "")

    await eventually(problem, "the server knows of the loss", within_s=3, every_s=0.02)


@dataclass(frozen=True, slots=True)
class Unplugged:
    """One pulled plug; `back_ms` is from the plug's return to the server's word of it."""

    stopping: Stopping
    said_ms: float
    back_ms: float
    moved_by_itself: bool


async def serial_unplugged(n: int, **settings: Any) -> list[Row]:
    """Time from pulling the plug; the key is held until after the line has come back."""
    async with staged(**settings) as stage, chromiums() as launch:
        page = await launch(stage.server.url)
        await page.take_the_wheel()
        await page.take_notes()

        async def trial() -> Unplugged | None:
            await stage.moving(page.press)
            await page.take_notes()
            await random_phase()
            since_s = await stage.board.unplug()
            await _problem(stage)
            said_ms = (await page.reads(FOR_GUESTS) - since_s) * 1000
            await asyncio.sleep(max(0.0, since_s + _LOOK_S - time.monotonic()))
            until_s = time.monotonic()
            plugged_s = await stage.board.plug()
            await stage.answers(within_s=10)
            back_ms = (time.monotonic() - plugged_s) * 1000
            await asyncio.sleep(_HELD_ON_S)
            stage.record.read()
            now_s = time.monotonic()
            moved = any(frame.moves for frame in stage.record.between(plugged_s, now_s))
            await page.let_go()
            stopping = stage.outcome(since_s, until_s)
            return Unplugged(stopping, said_ms, back_ms, moved) if stopping else None

        trials = await repeat("serial-unplugged", n, trial)
    found = trials.results
    return [
        timed(
            "serial-unplugged",
            "serial line unplugged → the board stops by itself",
            [one.stopping.ends_ms for one in found],
            GOAL_MS,
            void=trials.void,
        ),
        timed(
            "serial-unplugged: said",
            "… → the page says so",
            [one.said_ms for one in found],
            SAID_MS,
        ),
        timed(
            "serial-unplugged: back",
            "… plugged in again → the server drives it",
            [one.back_ms for one in found],
            BACK_MS,
        ),
        counted(
            "serial-unplugged: motion",
            "… motions without a new deliberate command",
            sum(one.moved_by_itself for one in found),
            len(found),
        ),
    ]
