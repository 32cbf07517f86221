"""The operator is gone: their network vanishes, or their browser freezes or is killed."""

from __future__ import annotations

import asyncio
import time
from functools import partial
from typing import TYPE_CHECKING, Final

from e2e.measure.row import summed
from e2e.stop.operator import Browser, RawOperator
from e2e.stop.page import Chromium, chromiums
from e2e.stop.relay import Relay
from e2e.stop.stage import random_phase, staged
from e2e.stop.trials import Trials, repeat, told
from wax.config.settings import Settings

if TYPE_CHECKING:
    from typing import Any

    from e2e.measure.row import Row
    from e2e.stop.record import Stopping
    from e2e.stop.stage import Stage

GOAL_MS: Final = 200.0
GOAL_MM: Final = Settings().drive.max_stop_distance_m * 1000
_LOOK_S: Final = 0.4
"""Shorter than the second after which the server considers an operator lost."""
_A_CONNECTION: Final = 5
"""Trials over each."""


async def network_vanishes(n: int, **settings: Any) -> list[Row]:
    """Time from the last command that left the operator's network, without a goodbye.

    The robot runs as fast as it may, since its operator sees: how far it goes on is the other
    figure. A peer's own congestion control is slow to trust a network that has vanished a few
    times, so it comes back with a new connection now and then.
    """
    trials: Trials[Stopping] = Trials()
    late_ms = 0.0
    browser = Browser()
    async with staged(**settings) as stage:
        while (left := n - len(trials.results)) > 0:
            relay = Relay()
            peer = RawOperator(stage.server, browser=browser, relay=relay, sees=True)
            async with peer as operator:
                await operator.join()
                vanish = partial(_vanish, stage, operator, relay)
                trials.add(await repeat("network-vanishes", min(left, _A_CONNECTION), vanish))
                late_ms = max(late_ms, operator.worst_late_s * 1000)
    return [
        told(
            "network-vanishes",
            "operator's network vanishes at full speed: last packet that arrived → stop frame",
            trials,
            GOAL_MS,
            peer_late_ms=late_ms,
        ),
        summed(
            "network-vanishes: distance",
            "… way from there to standstill",
            "mm",
            [one.travelled_mm for one in trials.results],
            GOAL_MM,
        ),
    ]


async def _vanish(stage: Stage, operator: RawOperator, relay: Relay) -> Stopping | None:
    await stage.drive(operator)
    if not await stage.at_full_speed():
        return None
    await random_phase()
    relay.cut()
    cut_s = time.monotonic()
    last_s = relay.last_command_s
    await asyncio.sleep(_LOOK_S)
    until_s = time.monotonic()
    relay.up.clear()
    relay.mend()
    stage.record.read()
    return stage.record.stopping(last_s, until_s) if stage.record.moved_at(cut_s) else None


async def browser_frozen(n: int, **settings: Any) -> Row:
    """Time from SIGSTOP to all processes of a browser with a key held down."""
    async with staged(**settings) as stage, chromiums() as launch:
        page = await launch(stage.server.url)
        await page.take_the_wheel()

        async def trial() -> Stopping | None:
            await hold(stage, page)
            since_s = time.monotonic()
            page.freeze()
            try:
                await asyncio.sleep(_LOOK_S)
                until_s = time.monotonic()
            finally:
                page.thaw()
            await page.let_go()
            return stage.outcome(since_s, until_s)

        trials = await repeat("browser-frozen", n, trial)
    return told("browser-frozen", "browser frozen (SIGSTOP) → stop frame", trials, GOAL_MS)


async def browser_killed(n: int, **settings: Any) -> Row:
    """Time from SIGKILL to all processes of a browser; the next in the queue is connected."""
    short = {"turns": {"grace_s": 0.0}}
    async with staged(short, **settings) as stage, chromiums() as launch:
        page = await launch(stage.server.url)
        await page.take_the_wheel()

        async def trial() -> Stopping | None:
            nonlocal page
            following = await launch(stage.server.url)
            await following.viewer.join()
            await hold(stage, page)
            since_s = time.monotonic()
            page.kill()
            await asyncio.sleep(_LOOK_S)
            until_s = time.monotonic()
            await page.close()
            page = following
            await page.viewer.drives(15)
            return stage.outcome(since_s, until_s)

        trials = await repeat("browser-killed", n, trial)
    return told("browser-killed", "browser killed → stop frame", trials, GOAL_MS)


async def hold(stage: Stage, page: Chromium) -> None:
    """Press anew and return at random phase while the robot moves."""
    await stage.moving(page.press)
    await random_phase()
