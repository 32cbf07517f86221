"""How soon a voice is silent at the robot's speaker, after the host mutes it."""

from __future__ import annotations

import asyncio
import json
import random
from typing import TYPE_CHECKING, Final

from e2e.delay.voice.stage import staged
from e2e.harness.page_clock import page_clock, unix_ms
from e2e.harness.scripts import has, press
from e2e.harness.wait import eventually
from e2e.measure.ear import BLOCK_MS, SILENT
from e2e.measure.errors import MeasureError
from e2e.measure.row import timed

if TYPE_CHECKING:
    from collections.abc import Sequence

    from playwright.async_api import Page

    from e2e.delay.voice.stage import Stage
    from e2e.harness.page_clock import PageClock
    from e2e.measure.ear import Block
    from e2e.measure.row import Row

MOST_MS: Final = 1000
"""What still sounds this long after the act was not silenced."""
_JUST_BEFORE_MS: Final = 50
_SOUNDS_WITHIN_S: Final = 15.0
_TELLS_WITHIN_S: Final = 10.0
_PHASE_S: Final = 0.4
_REST_S: Final = 0.3
_MUTED: Final = "The host has muted all voices."


async def muted(goal_ms: float, n: int) -> list[Row]:
    """Have the host mute all voices `n` times, at any moment of a voice that does not pause.

    The speaking operator's page must say so within the same time, or the goal is missed.
    """
    silent_ms: list[float | None] = []
    told_ms: list[float] = []
    async with staged("same-machine", pauses=False) as stage, stage.host() as host:
        await eventually(lambda: host.evaluate(press("Host")), "the host's panel opens")
        can_mute = has("Mute all voices")
        await eventually(lambda: host.evaluate(can_mute), "the host can mute voices")
        clock = await page_clock(stage.window.evaluate)
        hosts_clock = await page_clock(host.evaluate)
        for _ in range(n):
            await stage.window.keyboard.down("KeyT")
            if not await stage.ear.tap().hears(_SOUNDS_WITHIN_S):
                raise MeasureError(f"no voice sounded at the robot within {_SOUNDS_WITHIN_S:g} s")
            told = asyncio.create_task(
                stage.window.evaluate(f"waxVoice.reads({json.dumps(_MUTED)})")
            )
            silent, at_s = await _silent(stage, host, hosts_clock)
            read_s = clock.monotonic_s(await asyncio.wait_for(told, _TELLS_WITHIN_S))
            silent_ms.append(silent)
            told_ms.append((read_s - at_s) * 1000)
            await stage.window.keyboard.up("KeyT")
            await host.evaluate(press("Mute all voices"))
            await asyncio.sleep(_REST_S)
    what = "after the host mutes all voices, the robot’s speaker is silent"
    more = {
        "wrong": sum(one > goal_ms for one in told_ms),
        "told_after_at_most_ms": max(told_ms),
        "clock_error_ms": (clock.error_s + hosts_clock.error_s) * 1000,
    }
    return [timed("mute", what, silent_ms, goal_ms, **more)]


def silent_after_ms(heard: Sequence[Block], act_ms: float) -> float | None:
    """Return how long after `act_ms` the last sound ended; None if it went on.

    Raises `MeasureError` if it was silent before, or was not recorded for long enough.
    """
    ends_ms = [block.start_ms + BLOCK_MS for block in heard if block.rms > SILENT]
    if not any(act_ms - _JUST_BEFORE_MS < end_ms <= act_ms for end_ms in ends_ms):
        raise MeasureError("the robot's speaker was silent before")
    if heard[-1].start_ms < act_ms + MOST_MS:
        raise MeasureError("nobody listened for long enough")
    last_ms = ends_ms[-1] - act_ms
    return None if last_ms > MOST_MS else max(0.0, last_ms)


async def _silent(stage: Stage, host: Page, clock: PageClock) -> tuple[float | None, float]:
    """Mute; return the ms until it was silent, and when the host acted (monotonic seconds)."""
    tap = stage.ear.tap()
    await asyncio.sleep(_PHASE_S * (1 + random.random()))
    act = press("Mute all voices")  # a switch acts before this returns
    acted_ms = await host.evaluate(f"((at) => {act} ? at : null)(performance.now())")
    if acted_ms is None:
        raise MeasureError("the host's page has no such button")
    at_s = clock.monotonic_s(acted_ms)
    await asyncio.sleep((MOST_MS + _PHASE_S * 1000) / 1000)
    return silent_after_ms(tap.heard, unix_ms(at_s)), at_s
