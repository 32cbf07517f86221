"""Redis is killed, or all nodes, or LiveKit refuses the page's tokens, while somebody drives."""

from __future__ import annotations

import asyncio
import json
import random
from typing import TYPE_CHECKING, Any, Final

import jwt

from e2e.harness.wait import eventually
from e2e.load.cluster.bystander import Bystander
from e2e.load.cluster.driving import driving
from e2e.load.cluster.engine import KEY
from e2e.load.cluster.page import browsers, longest_gap_ms, now_ms, pictures_ms
from e2e.load.cluster.stage import ENGINES_OWN_S, staged
from e2e.measure.row import Row, timed

if TYPE_CHECKING:
    from playwright.async_api import Route

    from e2e.load.cluster.page import Browsers, Page
    from e2e.load.cluster.stage import Stage

SAID_MS: Final = 3000.0
_FULL: Final = "Watching is full"
_UNHEARD: Final = "No answer"
_WITHIN_S: Final = 20.0
_LIFE_S: Final = 600
"""Longer than a token lasts, and LiveKit's patience with it."""
_WITHOUT_REDIS_S: Final = 6.0
_STEADY_S: Final = 2.0
_PHASE_S: Final = 1.0


async def engine_lost(n: int) -> list[Row]:
    """Lose Redis, all nodes and the right to watch, `n` times each."""
    standing_ms: list[float | None] = []
    unheard_ms: list[float | None] = []
    gone_ms: list[float | None] = []
    refused_ms: list[float | None] = []
    untold = 0
    async with (
        staged(is_apart=True, server={"max_viewers": 1}) as stage,
        browsers() as chromium,
        driving(stage) as operator,
    ):
        bystander = Bystander(operator)
        page = await chromium.open(stage.server.url)
        await page.shows("room")
        for number in range(n):
            await asyncio.sleep(_STEADY_S + random.uniform(0, _PHASE_S))
            before = await _untold(stage)
            async with bystander.beside():
                stood_ms, said_ms = await _without_redis(stage, page)
            standing_ms.append(stood_ms)
            unheard_ms.append(said_ms)
            untold += await _untold(stage) - before
            await asyncio.sleep(_STEADY_S + random.uniform(0, _PHASE_S))
            async with bystander.beside():
                gone_ms.append(await _without_nodes(stage, page))
            async with bystander.beside():
                refused_ms.append(await _refused(stage, chromium, is_forged=number % 2 == 1))
    return [
        timed(
            "engine-lost: redis",
            f"Redis killed: no news of the queue → the page says “{_UNHEARD}”",
            unheard_ms,
            SAID_MS,
            untold=untold,
        ),
        timed(
            "engine-lost: redis, picture",
            "… and the longest time without a new picture",
            standing_ms,
            SAID_MS,
        ),
        timed(
            "engine-lost: nodes", f"all nodes killed → the page says “{_FULL}”", gone_ms, SAID_MS
        ),
        timed(
            "engine-lost: tokens",
            "a page's tokens have expired, or are not LiveKit's → it says so",
            refused_ms,
            SAID_MS,
        ),
        *bystander.rows("engine-lost"),
    ]


async def _without_redis(stage: Stage, page: Page) -> tuple[float, float | None]:
    """Return the longest time for which the page stood, and how soon it said what is missing."""
    lost_ms = now_ms()
    await stage.engine.redis.kill()
    await asyncio.sleep(_WITHOUT_REDIS_S)
    said_ms = await _says(page, _UNHEARD, lost_ms)
    until_ms = now_ms()
    await stage.engine.redis.start()
    await asyncio.sleep(_STEADY_S)
    gap_ms = longest_gap_ms(pictures_ms(await page.readings()), lost_ms, until_ms)
    await _whole(stage, page)
    return gap_ms, said_ms


async def _without_nodes(stage: Stage, page: Page) -> float | None:
    lost_ms = now_ms()
    await asyncio.gather(*(node.kill() for node in stage.engine.nodes))
    said_ms = await _says(page, _FULL, lost_ms)
    await asyncio.gather(*(stage.is_live(number, live=False) for number in range(2)))
    await asyncio.sleep(max(0.0, (lost_ms - now_ms()) / 1000 + ENGINES_OWN_S))
    for node in stage.engine.nodes:
        await node.start()
    await _whole(stage, page)
    return said_ms


async def _refused(stage: Stage, chromium: Browsers, *, is_forged: bool) -> float | None:
    """Open a page whose tokens LiveKit refuses; return how soon it says so."""
    told_ms: list[float] = []

    async def spoil(route: Route) -> None:
        response = await route.fetch()
        answer = await response.json()
        for seat in answer.get("rooms", ()):
            seat["token"] = _spoilt(seat["token"], is_forged=is_forged)
        told_ms.append(now_ms())
        await route.fulfill(response=response, body=json.dumps(answer))

    page = await chromium.prepare(stage.server.url)
    for path in ("offer", "seat"):
        await page.viewer.page.route(f"**/api/{path}", spoil)
    await page.viewer.page.goto(stage.server.url)
    await eventually(_true_of(told_ms), "the page is sent elsewhere")
    said_ms = await _says(page, _FULL, told_ms[0])
    await page.viewer.page.context.close()
    return said_ms


def _true_of(told: list[float]) -> Any:
    async def is_told() -> bool:
        return bool(told)

    return is_told


def _spoilt(token: str, *, is_forged: bool) -> str:
    """Make a token that has expired, or one that somebody else has signed."""
    claims = jwt.decode(token, KEY.secret, algorithms=["HS256"])
    if is_forged:
        return jwt.encode(claims, "x" * 32, algorithm="HS256")
    over = claims | {name: claims[name] - _LIFE_S for name in ("exp", "nbf")}
    return jwt.encode(over, KEY.secret, algorithm="HS256")


async def _says(page: Page, sentence: str, since_ms: float) -> float | None:
    """Return how long after a moment the page's status has a sentence; None for never."""

    async def said() -> list[float]:
        texts = await page.said("status")
        return [at_ms for at_ms, text in texts if at_ms >= since_ms and sentence in text]

    try:
        return (await eventually(said, "the page says it", within_s=_WITHIN_S))[0] - since_ms
    except AssertionError:
        return None


async def _untold(stage: Stage) -> int:
    """Return how often the rooms could not be told of the queue."""
    return int((await stage.server.status())["counters"].get("room messages lost", 0))


async def _whole(stage: Stage, page: Page) -> None:
    """Wait until both rooms are published to and the page watches in one of them."""
    await stage.are_live()
    await page.goes_on()
    await page.connects()
