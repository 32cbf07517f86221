"""A node is killed or hangs, Redis or all nodes are killed, while a page watches in a room."""

from __future__ import annotations

import asyncio
import random
from collections import defaultdict
from functools import partial
from typing import TYPE_CHECKING, Final

from e2e.load.cluster.driving import driving
from e2e.load.cluster.page import longest_gap_ms, now_ms, pages
from e2e.load.cluster.stage import staged
from e2e.measure.row import Row, timed

if TYPE_CHECKING:
    from e2e.load.cluster.page import Page
    from e2e.load.cluster.stage import Stage

ENGINES_OWN_S: Final = 5.5
"""LiveKit counts a dead node as alive for this long; one started before that gets no rooms."""
_FULL: Final = "All places to watch are taken"
_UNHEARD: Final = "No answer"
_STEADY_S: Final = 11.0
"""After this long in a room, a page trusts the rooms again that had failed."""
_SAYS_WITHIN_S: Final = 20.0
_FROZEN_S: Final = (0.0, 3.0)
"""How long a node stays frozen after it was given up."""
_WITHOUT_REDIS_S: Final = 6.0


async def _lost(stage: Stage, page: Page, *, hangs: bool) -> float | None:
    """Return the page's longest time without a new picture until its server knows of the loss."""
    number, lost_ms = stage.watched(page), now_ms()
    node = stage.engine.nodes[number]
    if hangs:
        node.freeze()
    else:
        await node.kill()
    await stage.is_live(number, live=False)
    noticed_ms = now_ms()
    await page.goes_on()
    gap_ms = longest_gap_ms(await page.pictures_ms(), lost_ms, noticed_ms)
    if hangs:
        await asyncio.sleep(random.uniform(*_FROZEN_S))
        node.thaw()
    else:
        await _sleep_until(lost_ms)
        await node.start()
    await stage.is_live(number, live=True)
    return gap_ms


async def _redis(stage: Stage, page: Page) -> float | None:
    lost_ms = now_ms()
    await stage.engine.redis.kill()
    await asyncio.sleep(_WITHOUT_REDIS_S)
    said_ms = await page.says(_UNHEARD, lost_ms, _SAYS_WITHIN_S)
    await stage.engine.redis.start()
    return said_ms


async def _nodes(stage: Stage, page: Page) -> float | None:
    lost_ms = now_ms()
    nodes = stage.engine.nodes
    await asyncio.gather(*(node.kill() for node in nodes))
    said_ms = await page.says(_FULL, lost_ms, _SAYS_WITHIN_S)
    for number in range(len(nodes)):
        await stage.is_live(number, live=False)
    await _sleep_until(lost_ms)
    for node in nodes:
        await node.start()
    await stage.are_live()
    return said_ms


async def _sleep_until(lost_ms: float) -> None:
    await asyncio.sleep(max(0.0, (lost_ms - now_ms()) / 1000 + ENGINES_OWN_S))


FAULTS: Final = (
    (
        "killed",
        "a node of LiveKit killed: the page without a new picture",
        1500.0,
        partial(_lost, hangs=False),
    ),
    ("frozen", "… a node hangs: the same", 1500.0, partial(_lost, hangs=True)),
    ("redis", f"Redis killed: no news of the queue → the page says “{_UNHEARD}”", 3000.0, _redis),
    ("nodes", f"all nodes killed → the page says “{_FULL}”", 3000.0, _nodes),
)
"""The subject of each row, and its goal in ms."""


async def faults(n: int) -> list[Row]:
    """Break it `n` times in each way, in turn, at random phase."""
    found_ms: dict[str, list[float | None]] = defaultdict(list)
    async with staged() as stage, pages() as open_page, driving(stage) as operator:
        page = await open_page(stage.server.url)
        await page.shows("room")
        for _round in range(n):
            for key, _, _, fault in FAULTS:
                await asyncio.sleep(_STEADY_S + random.uniform(0, 1))
                async with operator.beside():
                    found_ms[key].append(await fault(stage, page))
                await stage.are_live()
                await page.goes_on()
    rows = [
        timed(f"room-lost: {key}", what, found_ms[key], goal_ms) for key, what, goal_ms, _ in FAULTS
    ]
    return [*rows, operator.row()]
