"""The page's cost while somebody drives: main thread, heap, and whether it loses pictures."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import linear_regression, median
from typing import TYPE_CHECKING, Final

from playwright.async_api import async_playwright

from e2e.harness.chromium import launch_chromium
from e2e.load.page.driven import browsing, counters, counting, drives
from e2e.load.servers import STOCK, WAX, serving
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, judged, middle

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from playwright.async_api import Browser, CDPSession, Page, Route

SECONDS: Final = 15.0
GOAL_PERCENT: Final = 10.0
GOAL_MIB: Final = 1.0
LEAST_FPS: Final = 28.0
FEWEST: Final = 4
_STOCK: Final = 2
_HOLD_S: Final = 1.0
_KEYS: Final = ("ArrowLeft", "ArrowRight")
_SCRIPT: Final = Path(__file__).with_name("work.js").read_text(encoding="utf-8")
SHOWN_PERCENT: Final = 99.0
BARE_FPS: Final = 25.0
_BARE: Final = "/bare"
_HTML: Final = Path(__file__).with_name("bare.html").read_text(encoding="utf-8")
_SETTLE_S: Final = 3.0
_LOOK_S: Final = 10.0
_FRAMES: Final = "() => document.querySelector('video').getVideoPlaybackQuality().totalVideoFrames"


@dataclass(frozen=True, slots=True)
class Stretch:
    """Some seconds of one page: the main thread's share in percent, long tasks in ms, pictures.

    The heap is read at the end, after garbage collection.
    """

    at_min: float
    percent: float
    long_ms: list[float]
    fps: float
    heap_mib: float


async def work(n: int) -> list[Row]:
    """Drive to and fro for `n` stretches; watch stock's page, a bare video, for two."""
    async with browsing({}) as (browser, url):
        context = await browser.new_context(locale="en-GB")
        viewer = await drives(context, url, _SCRIPT)
        driving = asyncio.create_task(_drive(viewer.page))
        ours = await _stretches(viewer.page, n)
        driving.cancel()
        await asyncio.gather(driving, return_exceptions=True)
        await context.close()
    async with serving(STOCK) as server, async_playwright() as playwright:
        stock_browser = await launch_chromium(playwright)
        page = await stock_browser.new_page()
        await page.add_init_script(_SCRIPT)
        await page.goto(server.url)
        await page.wait_for_function("document.querySelector('video').currentTime > 3")
        stock = await _stretches(page, _STOCK)
        await stock_browser.close()
    return rows(ours, stock)


def rows(ours: Sequence[Stretch], stock: Sequence[Stretch]) -> list[Row]:
    """Sum up; raises `MeasureError` if there were fewer pictures than the figures assume.

    The heap's growth is the slope of the second half, over the whole time: in the first half caches
    fill and stay, while a leak continues.
    """
    slowest = min(one.fps for one in ours)
    if slowest < LEAST_FPS:
        raise MeasureError(f"{slowest:.1f} pictures a second came, not 30: the machine is busy")
    if len(ours) < FEWEST:
        raise MeasureError(f"{len(ours)} stretches are too few for a slope")
    long_ms = [ms for one in ours for ms in one.long_ms]
    late, minutes = ours[len(ours) // 2 :], ours[-1].at_min
    slope = linear_regression([one.at_min for one in late], [one.heap_mib for one in late]).slope
    worst, usual = max(one.percent for one in ours), median(one.percent for one in stock)
    work = "the page's main thread while driving at 30 fps, worst (stock: a bare video, median)"
    share: dict[str, float | None] = {WAX: worst, STOCK: usual}
    longs, growth = {WAX: float(len(long_ms))}, {WAX: slope * minutes}
    row = partial(judged, n=len(ours))
    return [
        row("page: main thread", work, "% of a core", share, GOAL_PERCENT),
        row("page: long tasks", "… tasks of more than 50 ms", "", longs, 0.0),
        row("page: heap", f"… its heap grows in {minutes:.1f} min by", "MiB", growth, GOAL_MIB),
    ]


async def _drive(page: Page) -> None:
    while True:
        for key in _KEYS:
            await page.keyboard.down(key)
            await asyncio.sleep(_HOLD_S)
            await page.keyboard.up(key)


async def _stretches(page: Page, n: int) -> list[Stretch]:
    session = await counting(page)
    begin = await counters(session)
    return [await _stretch(page, session, begin) for _ in range(n)]


async def _stretch(page: Page, session: CDPSession, begin: Mapping[str, float]) -> Stretch:
    await page.evaluate("window.waxLongTasks.length = 0")
    frames, before = await page.evaluate(_FRAMES), await counters(session)
    await asyncio.sleep(SECONDS)
    after = await counters(session)
    shown = await page.evaluate(_FRAMES) - frames
    long_ms = await page.evaluate("window.waxLongTasks")
    await session.send("HeapProfiler.collectGarbage")
    heap_mib = (await counters(session))["JSHeapUsedSize"] / (1 << 20)
    took_s = after["Timestamp"] - before["Timestamp"]  # by the browser's own clock
    percent = 100 * (after["TaskDuration"] - before["TaskDuration"]) / took_s
    at_min = (after["Timestamp"] - begin["Timestamp"]) / 60
    return Stretch(at_min, percent, long_ms, shown / took_s, heap_mib)


async def presented(n: int) -> list[Row]:
    """Watch each `n` times in turn: the page while it drives, and a bare video.

    Only one is open at a time; both are served by the same server, with the same camera.
    """
    pairs = []
    async with browsing({}) as (browser, url):
        for number in range(n):
            looks = (_driving, _bare) if number % 2 else (_bare, _driving)
            found = {look: await look(browser, url) for look in looks}
            pairs.append((found[_driving], found[_bare]))
    return presented_rows(pairs)


def presented_rows(pairs: Sequence[tuple[float, float]]) -> list[Row]:
    """Compare pair by pair; raises `MeasureError` if either got too few pictures to compare."""
    slowest = min(bare for _, bare in pairs)
    if slowest < BARE_FPS:
        raise MeasureError(f"of a bare video {slowest:.1f} pictures a second are presented, not 30")
    shown = [100 * ours / bare for ours, bare in pairs]
    what = "pictures presented while driving, of those of a bare video from the same server"
    row = partial(middle, n=len(pairs), at_least=True)
    return [row("page: presented", what, "%", shown, SHOWN_PERCENT)]


async def _driving(browser: Browser, url: str) -> float:
    async with await browser.new_context(locale="en-GB") as context:
        viewer = await drives(context, url, _SCRIPT)
        await viewer.page.keyboard.down(_KEYS[0])
        return await _fps(viewer.page)


async def _bare(browser: Browser, url: str) -> float:
    async def answer(route: Route) -> None:
        await route.fulfill(body=_HTML, content_type="text/html")

    async with await browser.new_context(locale="en-GB") as context:
        page = await context.new_page()
        await page.add_init_script(_SCRIPT)
        await page.route(f"**{_BARE}", answer)
        await page.goto(url + _BARE)
        await page.wait_for_function("document.querySelector('video').currentTime > 1")
        await asyncio.sleep(_SETTLE_S)
        return await _fps(page)


async def _fps(page: Page) -> float:
    return float(await page.evaluate(f"waxPresented({_LOOK_S * 1000})"))
