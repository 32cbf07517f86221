"""How much of a core the page's main thread takes while somebody drives, and in what pieces."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from playwright.async_api import async_playwright

from e2e.harness.chromium import launch_chromium
from e2e.load.page.driven import Counters, browsing, drives
from e2e.load.servers import STOCK, serving
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, counted, judged, summed
from e2e.measure.summary import summarize

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from playwright.async_api import Page

SECONDS: Final = 30.0
GOAL_PERCENT: Final = 10.0
LEAST_FPS: Final = 28.0
_KEY: Final = "ArrowLeft"
_WATCH: Final = """
(() => {
  window.waxLongTasks = [];
  new PerformanceObserver((list) => {
    for (const { duration } of list.getEntries()) window.waxLongTasks.push(duration);
  }).observe({ type: "longtask" });
})();
"""
_FRAMES: Final = "() => document.querySelector('video').getVideoPlaybackQuality().totalVideoFrames"


@dataclass(frozen=True, slots=True)
class Stretch:
    """`SECONDS` of one page: the main thread's share in percent, long tasks in ms, pictures."""

    percent: float
    long_ms: list[float]
    fps: float


async def main_thread(n: int) -> list[Row]:
    """Drive for `n` stretches; stock's page, a bare video, is looked at for as many."""
    async with browsing({}) as (browser, url):
        context = await browser.new_context(locale="en-GB")
        viewer = await drives(context, url, _WATCH)
        await viewer.page.keyboard.down(_KEY)
        ours = await _stretches(viewer.page, n)
        await viewer.page.keyboard.up(_KEY)
        await context.close()
    async with serving(STOCK) as server, async_playwright() as playwright:
        stock_browser = await launch_chromium(playwright)
        page = await stock_browser.new_page()
        await page.add_init_script(_WATCH)
        await page.goto(server.url)
        await page.wait_for_function("document.querySelector('video').currentTime > 3")
        stock = await _stretches(page, n)
        await stock_browser.close()
    return rows(ours, stock)


def rows(ours: Sequence[Stretch], stock: Sequence[Stretch]) -> list[Row]:
    """Sum up; raises `MeasureError` where fewer pictures came than the figures are about."""
    slowest = min(one.fps for one in ours)
    if slowest < LEAST_FPS:
        raise MeasureError(f"{slowest:.1f} pictures a second came, not 30: the machine is busy")
    long_ms = [ms for one in ours for ms in one.long_ms]
    spread = summarize([one.percent for one in stock])
    return [
        summed(
            "main-thread",
            "work of the page’s main thread while driving at 30 fps, of a core",
            "%",
            [one.percent for one in ours],
            GOAL_PERCENT,
            fps=slowest,
        ),
        judged(
            "main-thread: stock",
            "… of stock aiortc’s page, a bare video",
            "%",
            spread.model_dump(include={"median", "p95", "p99", "max"}),
            n=len(stock),
            column="median",
        ),
        counted(
            "main-thread: long",
            "… tasks of more than 50 ms",
            len(long_ms),
            round(len(ours) * SECONDS),
            longest_ms=max(long_ms, default=0.0),
        ),
    ]


async def _stretches(page: Page, n: int) -> list[Stretch]:
    counters = await Counters.of(page)
    return [await _stretch(page, counters) for _ in range(n)]


async def _stretch(page: Page, counters: Counters) -> Stretch:
    await page.evaluate("window.waxLongTasks.length = 0")
    frames, before = await page.evaluate(_FRAMES), await counters.read()
    await asyncio.sleep(SECONDS)
    after = await counters.read()
    shown = await page.evaluate(_FRAMES) - frames
    long_ms = await page.evaluate("window.waxLongTasks")
    return Stretch(share_percent(before, after), long_ms, shown / seconds(before, after))


def seconds(before: Mapping[str, float], after: Mapping[str, float]) -> float:
    """Return the time between two readings, by the browser's own clock."""
    return after["Timestamp"] - before["Timestamp"]


def share_percent(before: Mapping[str, float], after: Mapping[str, float]) -> float:
    """Return what all tasks between two readings took of that time."""
    return 100 * (after["TaskDuration"] - before["TaskDuration"]) / seconds(before, after)
