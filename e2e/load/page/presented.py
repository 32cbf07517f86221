"""Whether the head-up display costs pictures: as many are presented as of a bare video."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import TYPE_CHECKING, Final

from e2e.load.page.driven import browsing, drives
from e2e.load.servers import WAX
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, judged
from e2e.measure.summary import summarize

if TYPE_CHECKING:
    from collections.abc import Sequence

    from playwright.async_api import Browser, Page, Route

SECONDS: Final = 10.0
GOAL_PERCENT: Final = 99.0
LEAST_FPS: Final = 25.0
_KEY: Final = "ArrowLeft"
_BARE: Final = "/bare"
_HTML: Final = Path(__file__).with_name("bare.html").read_text(encoding="utf-8")
_SETTLE_S: Final = 3.0
_COUNT: Final = """(ms) => new Promise((resolve) => {
    const video = document.querySelector("video");
    let first = null;
    const onFrame = (now, { presentedFrames }) => {
        first ??= { now, presentedFrames };
        const took = now - first.now;
        if (took >= ms) resolve((presentedFrames - first.presentedFrames) / took * 1000);
        else video.requestVideoFrameCallback(onFrame);
    };
    video.requestVideoFrameCallback(onFrame);
})"""
"""Pictures a second that the compositor was given, by its own count."""


async def presented(n: int) -> list[Row]:
    """Look `n` times at each in turn: the page while it drives, and a bare video.

    The other page is closed meanwhile; both are served by the same server, with the same camera.
    """
    pairs = []
    async with browsing({}) as (browser, url):
        for number in range(n):
            looks = (_driving, _bare) if number % 2 else (_bare, _driving)
            found = {look: await look(browser, url) for look in looks}
            pairs.append((found[_driving], found[_bare]))
    return rows(pairs)


def rows(pairs: Sequence[tuple[float, float]]) -> list[Row]:
    """Compare pair by pair; raises `MeasureError` where too few came to either to say anything."""
    slowest = min(bare for _, bare in pairs)
    if slowest < LEAST_FPS:
        raise MeasureError(f"of a bare video {slowest:.1f} pictures a second are presented, not 30")
    spread = summarize([100 * ours / bare for ours, bare in pairs])
    return [
        judged(
            "page: presented",
            "pictures presented while driving, of those of a bare video from the same server",
            "%",
            {WAX: spread.median},
            GOAL_PERCENT,
            n=len(pairs),
            at_least=True,
            spread=spread,
        )
    ]


async def _driving(browser: Browser, url: str) -> float:
    context = await browser.new_context(locale="en-GB")
    viewer = await drives(context, url)
    await viewer.page.keyboard.down(_KEY)
    found = await _fps(viewer.page)
    await viewer.page.keyboard.up(_KEY)
    await context.close()
    return found


async def _bare(browser: Browser, url: str) -> float:
    context = await browser.new_context(locale="en-GB")
    page = await context.new_page()

    async def answer(route: Route) -> None:
        await route.fulfill(body=_HTML, content_type="text/html")

    await page.route(f"**{_BARE}", answer)
    await page.goto(url + _BARE)
    await page.wait_for_function("document.querySelector('video').currentTime > 1")
    await asyncio.sleep(_SETTLE_S)
    found = await _fps(page)
    await context.close()
    return found


async def _fps(page: Page) -> float:
    return float(await page.evaluate(_COUNT, SECONDS * 1000))
