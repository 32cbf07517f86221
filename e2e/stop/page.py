"""A viewer in a Chromium of their own, which can be frozen, killed, and hidden by another tab."""

from __future__ import annotations

import asyncio
import os
import signal
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING, Final

import psutil
from playwright.async_api import Error as PlaywrightError
from playwright.async_api import async_playwright
from tests.free_port import free_port

from e2e.harness.chromium import launch_chromium
from e2e.harness.scripts import press, says
from e2e.harness.viewer import Viewer
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable

    from playwright.async_api import Browser, Page

    from e2e.harness.page_clock import PageClock

    Launch = Callable[[str], Awaitable["Chromium"]]

KEY: Final = "ArrowUp"
_CLOSE_S: Final = 3.0


class Chromium:
    """One browser with one page, which drives ahead by a key."""

    def __init__(self, browser: Browser, pid: int, viewer: Viewer) -> None:
        self.viewer = viewer
        self._browser = browser
        self._pid = pid
        self._pids: list[int] = []

    async def press(self) -> None:
        """Release and press again, as required after every fault."""
        await self.viewer.page.keyboard.up(KEY)
        await asyncio.sleep(0.08)
        self.find()
        await self.viewer.page.keyboard.down(KEY)

    async def close(self) -> None:
        """Close whatever is left of it, frozen or killed."""
        self.send(signal.SIGCONT)
        with suppress(PlaywrightError, TimeoutError):
            async with asyncio.timeout(_CLOSE_S):
                await self._browser.close()

    def find(self) -> None:
        """Find its processes before they are signalled, because that takes a while."""
        children = psutil.Process(self._pid).children(recursive=True)
        self._pids = [self._pid, *(child.pid for child in children)]

    def send(self, how: signal.Signals) -> None:
        """Send a signal to all of its processes, including the network's."""
        for pid in self._pids:
            with suppress(ProcessLookupError):
                os.kill(pid, how)


@asynccontextmanager
async def chromiums() -> AsyncIterator[Launch]:
    """Yield a function that opens a page in a browser of its own; all are closed at the end."""
    opened: list[Chromium] = []
    async with async_playwright() as playwright:

        async def launch(url: str) -> Chromium:
            browser = await launch_chromium(playwright)
            session = await browser.new_browser_cdp_session()
            info = (await session.send("SystemInfo.getProcessInfo"))["processInfo"]
            pid = next(int(one["id"]) for one in info if one["type"] == "browser")
            viewer = await Viewer.at(await browser.new_context(), url)
            await viewer.sees_picture()
            opened.append(Chromium(browser, pid, viewer))
            return opened[-1]

        try:
            yield launch
        finally:
            for one in opened:
                await one.close()


class Tab:
    """A tab that drives by a held key, and that another tab can really hide."""

    clock: PageClock
    other: Page

    def __init__(self, page: Page) -> None:
        self.page = page

    @classmethod
    @asynccontextmanager
    async def opened(cls, url: str, script: str) -> AsyncIterator[Tab]:
        """Open a page in a browser of its own; `script` runs in it before the page's."""
        port = free_port()
        async with (
            async_playwright() as playwright,
            await launch_chromium(playwright, f"--remote-debugging-port={port}"),
            # Playwright tells pages of a browser that it launched that they are always in front.
            await playwright.chromium.connect_over_cdp(
                f"http://127.0.0.1:{port}", no_defaults=True
            ) as browser,
        ):
            [context] = browser.contexts
            await context.add_init_script(script)
            page = await context.new_page()
            await page.goto(url)
            yield cls(page)

    async def drive(self) -> None:
        """Wait until the page drives; join if it has no turn."""

        async def drives() -> bool:
            await self.page.evaluate(press("Join the queue"))
            return bool(await self.page.evaluate(says("You are driving")))

        await eventually(drives, "the tab drives", within_s=20)

    async def press(self) -> None:
        await self.release()
        await asyncio.sleep(0.08)
        await self.page.keyboard.down(KEY)

    async def release(self) -> None:
        await self.page.keyboard.up(KEY)
