"""The operator drives blind: the camera freezes, or the pictures do not arrive."""

from __future__ import annotations

import asyncio
import time
from contextlib import closing
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from e2e.harness.wait import eventually
from e2e.measure.row import timed
from e2e.stop.camera import PLUG_IN, Control
from e2e.stop.operator import RawOperator
from e2e.stop.page import chromiums, through
from e2e.stop.relay import Relay
from e2e.stop.stage import random_phase, staged
from e2e.stop.trials import Trials, repeat
from wax.config.settings import Settings

if TYPE_CHECKING:
    from e2e.measure.row import Row
    from e2e.stop.stage import Stage

GOAL_MS: Final = 200.0
SLOW_S: Final = Settings().drive.slow_picture_age_ms / 1000
STOP_S: Final = Settings().drive.stop_picture_age_ms / 1000
"""The shipped limits of the picture's age; the line's own delay is added."""
_FINE_MMPS: Final = 0.3 * 600 + 2
"""Slow speed of the shipped configuration, with a margin for rounding."""
_LOOK_S: Final = 1.4
_FRESH_S: Final = 0.3


@dataclass(frozen=True, slots=True)
class Dimmed:
    """The time from each limit of the picture's age to the rule's effect; None without one."""

    slowed_ms: float | None
    stopped_ms: float | None
    moved_again: int


async def camera_freezes(n: int, **settings: Any) -> list[Row]:
    """Freeze the suite's own camera, with a real page."""
    with Control() as control:
        async with (
            staged(PLUG_IN, environment=control.environment, **settings) as stage,
            chromiums() as launch,
        ):
            page = await launch(stage.server.url)
            await page.take_the_wheel()
            await page.viewer.speed("Fast").click()

            async def trial() -> Dimmed | None:
                await stage.moving(page.press)
                await fast(stage)
                await random_phase()
                newest_s = await control.freeze()
                await asyncio.sleep(_LOOK_S)
                found = dimmed(stage, newest_s, time.monotonic())
                await page.let_go()
                control.thaw()
                await asyncio.sleep(0.5)
                return found

            trials = await repeat("blind-camera", n, trial)
    return _rows("camera frozen", trials)


async def video_starves(n: int, **settings: Any) -> list[Row]:
    """Let a raw peer whose picture is on report truthfully that no newer one has come."""
    async with (
        staged(**settings) as stage,
        RawOperator(stage.server, sees=True) as operator,
    ):
        await operator.join()

        async def trial() -> Dimmed | None:
            operator.sees_now = True
            await stage.drive(operator)
            await fast(stage)
            operator.seen_server_ms, operator.sees_now = operator.server_ms(), False
            newest_s = time.monotonic()
            await asyncio.sleep(_LOOK_S)
            return dimmed(stage, newest_s, time.monotonic())

        trials = await repeat("blind-video", n, trial)
    return _rows("no new picture", trials)


async def page_starves(n: int, **settings: Any) -> list[Row]:
    """Lose the pictures to a real page, while everything else passes."""
    with closing(Relay()) as relay:
        async with staged(**settings) as stage, chromiums() as launch:
            page = await launch(stage.server.url, prepare=through(relay))
            await page.look()
            await page.take_the_wheel()
            await page.viewer.speed("Fast").click()

            async def sees() -> bool:
                return time.monotonic() - await page.newest_s() < _FRESH_S

            async def trial() -> Dimmed | None:
                await eventually(sees, "the page sees again", within_s=15)
                await stage.moving(page.press)
                await fast(stage)
                await random_phase()
                relay.starves = True
                await asyncio.sleep(_LOOK_S)
                until_s = time.monotonic()
                found = dimmed(stage, await page.newest_s(), until_s)
                relay.starves = False
                await page.let_go()
                return found

            trials = await repeat("blind-page", n, trial)
    return _rows("picture starved on its way to a page", trials)


async def fast(stage: Stage) -> None:
    """Wait until the commanded speed is clearly above slow speed."""

    async def so() -> bool:
        stage.record.read()
        return stage.record.frames[-1].left_mmps > 1.5 * _FINE_MMPS

    await eventually(so, "the robot is fast, since its operator sees", every_s=0.01)


def dimmed(stage: Stage, newest_s: float, until_s: float) -> Dimmed | None:
    """Return the effects after the last picture; None if the robot stood before the first limit."""
    record = stage.record
    record.read()
    if not record.moved_at(newest_s + SLOW_S - 0.05):
        return None
    frames = record.between(newest_s, until_s)
    slow_s = next((one.at_s for one in frames if one.left_mmps <= _FINE_MMPS), None)
    stopping = record.stopping(newest_s, until_s)
    told_ms = stopping.told_ms
    return Dimmed(
        slowed_ms=None if slow_s is None else (slow_s - newest_s - SLOW_S) * 1000,
        stopped_ms=None if told_ms is None else told_ms - STOP_S * 1000,
        moved_again=stopping.moved_again,
    )


def _rows(name: str, trials: Trials[Dimmed]) -> list[Row]:
    found = trials.results
    wrong = sum(one.moved_again for one in found)
    return [
        timed(
            f"{name}, slowed",
            f"{name}: older than {SLOW_S * 1000:g} ms → slow speed on the wire",
            [one.slowed_ms for one in found],
            GOAL_MS,
            void=trials.void,
        ),
        timed(
            f"{name}, stopped",
            f"{name}: older than {STOP_S * 1000:g} ms → stop frame",
            [one.stopped_ms for one in found],
            GOAL_MS,
            wrong=wrong,
        ),
    ]
