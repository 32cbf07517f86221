"""What the page takes while somebody drives: its main thread, long tasks, growth of its heap."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from statistics import linear_regression, median
from typing import TYPE_CHECKING, Final

from playwright.async_api import async_playwright

from e2e.harness.chromium import launch_chromium
from e2e.load.page.driven import Counters, browsing, drives
from e2e.load.servers import STOCK, WAX, serving
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, judged

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from playwright.async_api import Page

SECONDS: Final = 15.0
GOAL_PERCENT: Final = 10.0
GOAL_MIB: Final = 1.0
LEAST_FPS: Final = 28.0
FEWEST: Final = 4
_STOCK: Final = 2
_HOLD_S: Final = 1.0
_KEYS: Final = ("ArrowLeft", "ArrowRight")
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
    """Some seconds of one page: the main thread's share in percent, long tasks in ms, pictures.

    The heap is read at the end, after its garbage was collected.
    """

    at_min: float
    percent: float
    long_ms: list[float]
    fps: float
    heap_mib: float


async def work(n: int) -> list[Row]:
    """Drive to and fro for `n` stretches; stock's page, a bare video, is looked at for two."""
    async with browsing({}) as (browser, url):
        context = await browser.new_context(locale="en-GB")
        viewer = await drives(context, url, _WATCH)
        driving = asyncio.create_task(_drive(viewer.page))
        ours = await _stretches(viewer.page, n)
        driving.cancel()
        await asyncio.gather(driving, return_exceptions=True)
        await context.close()
    async with serving(STOCK) as server, async_playwright() as playwright:
        stock_browser = await launch_chromium(playwright)
        page = await stock_browser.new_page()
        await page.add_init_script(_WATCH)
        await page.goto(server.url)
        await page.wait_for_function("document.querySelector('video').currentTime > 3")
        stock = await _stretches(page, _STOCK)
        await stock_browser.close()
    return rows(ours, stock)


def rows(ours: Sequence[Stretch], stock: Sequence[Stretch]) -> list[Row]:
    """Sum up; raises `MeasureError` where fewer pictures came than the figures are about.

    The heap's growth is the slope of the second half over the whole time: in the first one caches
    fill that stay, and what leaks goes on leaking.
    """
    slowest = min(one.fps for one in ours)
    if slowest < LEAST_FPS:
        raise MeasureError(f"{slowest:.1f} pictures a second came, not 30: the machine is busy")
    if len(ours) < FEWEST:
        raise MeasureError(f"{len(ours)} stretches are too few for a slope")
    long_ms = [ms for one in ours for ms in one.long_ms]
    late, minutes = ours[len(ours) // 2 :], ours[-1].at_min
    slope = linear_regression([one.at_min for one in late], [one.heap_mib for one in late]).slope
    growth_mib = slope * minutes
    stock_percent = median(one.percent for one in stock)
    found: tuple[tuple[str, str, str, dict[str, float | None], float], ...] = (
        (
            "main thread",
            "the page's main thread while driving at 30 fps, worst (stock: a bare video, median)",
            "% of a core",
            {WAX: max(one.percent for one in ours), STOCK: stock_percent},
            GOAL_PERCENT,
        ),
        ("long tasks", "… tasks of more than 50 ms", "", {WAX: float(len(long_ms))}, 0.0),
        ("heap", f"… its heap grows in {minutes:.0f} min by", "MiB", {WAX: growth_mib}, GOAL_MIB),
    )
    return [
        judged(f"page: {key}", what, unit, values, goal, n=len(ours))
        for key, what, unit, values, goal in found
    ]


async def _drive(page: Page) -> None:
    while True:
        for key in _KEYS:
            await page.keyboard.down(key)
            await asyncio.sleep(_HOLD_S)
            await page.keyboard.up(key)


async def _stretches(page: Page, n: int) -> list[Stretch]:
    counters = await Counters.of(page)
    begin = await counters.read()
    return [await _stretch(page, counters, begin) for _ in range(n)]


async def _stretch(page: Page, counters: Counters, begin: Mapping[str, float]) -> Stretch:
    await page.evaluate("window.waxLongTasks.length = 0")
    frames, before = await page.evaluate(_FRAMES), await counters.read()
    await asyncio.sleep(SECONDS)
    after = await counters.read()
    shown = await page.evaluate(_FRAMES) - frames
    long_ms = await page.evaluate("window.waxLongTasks")
    await counters.collect_garbage()
    heap_mib = (await counters.read())["JSHeapUsedSize"] / (1 << 20)
    return Stretch(
        seconds(begin, after) / 60,
        share_percent(before, after),
        long_ms,
        shown / seconds(before, after),
        heap_mib,
    )


def seconds(before: Mapping[str, float], after: Mapping[str, float]) -> float:
    """Return the time between two readings, by the browser's own clock."""
    return after["Timestamp"] - before["Timestamp"]


def share_percent(before: Mapping[str, float], after: Mapping[str, float]) -> float:
    """Return what all tasks between two readings took of that time."""
    return 100 * (after["TaskDuration"] - before["TaskDuration"]) / seconds(before, after)
