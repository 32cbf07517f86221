"""A page that drives, in a browser whose counters are read by the DevTools protocol."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any, Final

from playwright.async_api import async_playwright

from e2e.harness.chromium import launch_chromium
from e2e.harness.viewer import Viewer
from e2e.load.servers import WAX, serving

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from playwright.async_api import Browser, BrowserContext, CDPSession, Page

_SETTLE_S: Final = 3.0
"""By then the picture is as large as the link carries, and no control is held."""


async def counting(page: Page) -> CDPSession:
    """Let Chromium count what a page takes, for `counters`."""
    session = await page.context.new_cdp_session(page)
    await session.send("Performance.enable", {"timeDomain": "timeTicks"})
    return session


async def counters(session: CDPSession) -> dict[str, float]:
    told = await session.send("Performance.getMetrics")
    return {one["name"]: float(one["value"]) for one in told["metrics"]}


@asynccontextmanager
async def browsing(server_settings: dict[str, Any]) -> AsyncIterator[tuple[Browser, str]]:
    """Run a server and a browser; yield the browser and the page's address."""
    async with serving(WAX, **server_settings) as server, async_playwright() as playwright:
        browser = await launch_chromium(playwright)
        yield browser, server.url
        await browser.close()


async def drives(context: BrowserContext, url: str, script: str) -> Viewer:
    """Open the page and join; return once it drives and its picture has settled."""
    await context.add_init_script(script)
    viewer = await Viewer.at(context, url)
    await viewer.sees_picture()
    await viewer.puts_the_first_card_away()
    await viewer.takes_the_wheel()
    await asyncio.sleep(_SETTLE_S)
    return viewer
