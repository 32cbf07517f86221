"""A node is killed, or freezes, while a page watches in its room and somebody drives."""

from __future__ import annotations

import asyncio
import random
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from e2e.load.cluster.bystander import Bystander
from e2e.load.cluster.driving import driving
from e2e.load.cluster.page import browsers, longest_gap_ms, now_ms, pictures_ms
from e2e.load.cluster.stage import ENGINES_OWN_S, staged
from e2e.measure.row import Row, timed

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.load.cluster.page import Page
    from e2e.load.cluster.stage import Stage

PICTURE_MS: Final = 1500.0
NOTICED_MS: Final = 4000.0
BACK_MS: Final = 5000.0
_STEADY_S: Final = 11.0
"""After so long in a room a page counts those that failed before as good again."""
_FROZEN_S: Final = (0.0, 3.0)
"""For so long a node stays frozen after it was given up."""
_PHASE_S: Final = 1.0


@dataclass(frozen=True, slots=True)
class Fault:
    """When the node was lost, given up by the robot's server, there again, and published to."""

    lost_ms: float
    noticed_ms: float
    there_ms: float
    back_ms: float


async def node_lost(n: int) -> list[Row]:
    """Lose the node that is watched `n` times each way, by turns."""
    found: dict[str, list[Fault]] = {"killed": [], "frozen": []}
    gaps_ms: dict[str, list[float]] = {"killed": [], "frozen": []}
    async with (
        staged(is_apart=True, server={"max_viewers": 1}) as stage,
        browsers() as chromium,
        driving(stage) as operator,
    ):
        bystander = Bystander(operator)
        page = await chromium.open(stage.server.url)
        await page.shows("room")
        for _ in range(n):
            for how, lose in (("killed", _kill), ("frozen", _freeze)):
                await asyncio.sleep(_STEADY_S + random.uniform(0, _PHASE_S))
                async with bystander.beside():
                    fault = await lose(stage, page)
                await page.goes_on()
                gaps_ms[how].append(await _gap_ms(page, fault))
                found[how].append(fault)
    return [
        row for how in found for row in _rows(how, found[how], gaps_ms[how])
    ] + bystander.rows("node-lost")  # fmt: skip


def _rows(how: str, faults: Sequence[Fault], gaps_ms: Sequence[float]) -> list[Row]:
    noticed_ms = [one.noticed_ms - one.lost_ms for one in faults]
    back_ms = [one.back_ms - one.there_ms for one in faults]
    there = "started again" if how == "killed" else "going on"
    key = f"node-lost: {how}"
    return [
        timed(key, f"node {how}: time without a new picture on the page", gaps_ms, PICTURE_MS),
        timed(f"{key}: noticed", "… the robot's server notices", noticed_ms, NOTICED_MS),
        timed(f"{key}: back", f"… {there} → published to again", back_ms, BACK_MS),
    ]


async def _kill(stage: Stage, page: Page) -> Fault:
    number = stage.watched(page)
    lost_ms = now_ms()
    await stage.engine.nodes[number].kill()
    await stage.is_live(number, live=False)
    noticed_ms = now_ms()
    await asyncio.sleep(max(0.0, (lost_ms - noticed_ms) / 1000 + ENGINES_OWN_S))
    await stage.engine.nodes[number].start()
    there_ms = now_ms()
    await stage.is_live(number, live=True)
    return Fault(lost_ms, noticed_ms, there_ms, now_ms())


async def _freeze(stage: Stage, page: Page) -> Fault:
    number = stage.watched(page)
    lost_ms = now_ms()
    stage.engine.nodes[number].freeze()
    await stage.is_live(number, live=False)
    noticed_ms = now_ms()
    await asyncio.sleep(random.uniform(*_FROZEN_S))
    stage.engine.nodes[number].thaw()
    there_ms = now_ms()
    await stage.is_live(number, live=True)
    return Fault(lost_ms, noticed_ms, there_ms, now_ms())


async def _gap_ms(page: Page, fault: Fault) -> float:
    """Return the longest time without a new picture from the loss to the node's return."""
    shown_ms = pictures_ms(await page.readings())
    return longest_gap_ms(shown_ms, fault.lost_ms, fault.noticed_ms)
