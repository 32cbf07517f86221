"""First picture: from the start of the page's navigation to its first presented video frame."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from playwright.async_api import async_playwright

from e2e.harness.chromium import launch_chromium
from e2e.load.servers import SIDES, STOCK, WAX, serving
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, judged
from e2e.measure.summary import summarize

if TYPE_CHECKING:
    from playwright.async_api import Browser

GOAL_MS: Final = 500.0
_PAUSE_MS: Final = 300
_FIRST_FRAME: Final = """
(() => {
  window.waxBenchFirstFrameMs = new Promise((resolve) => {
    const watch = (video) => {
      if (video.waxBench) return;
      video.waxBench = true;
      video.requestVideoFrameCallback(() => resolve(performance.now()));
    };
    new MutationObserver(() => document.querySelectorAll("video").forEach(watch))
      .observe(document, { childList: true, subtree: true });
    setTimeout(() => resolve(null), 20_000);
  });
})();
"""
"""Promises when the first video frame is presented, ms since the navigation began; else null."""


async def first_picture(n: int) -> list[Row]:
    """Open each server's page `n` times, the first of a new browser process not counted.

    Stock includes what aiortc waits for the browser's mDNS names: a second where nobody answers
    multicast, as inside most containers.
    """
    found = {side: summarize(await _loads_ms(side, n)) for side in SIDES}
    return [
        judged(
            "first-picture",
            "first picture after opening the page, median",
            "ms",
            {WAX: found[WAX].median, STOCK: found[STOCK].median},
            GOAL_MS,
            n=n,
            spread=found[WAX],
        )
    ]


async def _loads_ms(side: str, n: int) -> list[float]:
    async with serving(side) as server, async_playwright() as playwright:
        browser = await launch_chromium(playwright)
        each_ms = [await _load_ms(browser, server.url) for _ in range(n + 1)]
        await browser.close()
    return each_ms[1:]


async def _load_ms(browser: Browser, url: str) -> float:
    """Open the page without a past: no cache, no storage, no open connection."""
    context = await browser.new_context(locale="en-GB")
    await context.add_init_script(_FIRST_FRAME)
    page = await context.new_page()
    await page.goto(url, wait_until="commit")
    first_ms = await page.evaluate("window.waxBenchFirstFrameMs")
    if first_ms is None:
        raise MeasureError(f"{url}: no picture in 20 s")
    await page.goto("about:blank")
    # The server is given time to let the viewer go, so that pages do not overlap.
    await page.wait_for_timeout(_PAUSE_MS)
    await context.close()
    return float(first_ms)
