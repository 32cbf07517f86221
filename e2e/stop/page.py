"""A viewer in a Chromium of their own, whose processes can be frozen and killed."""

from __future__ import annotations

import asyncio
import os
import signal
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING, Final

import psutil  # type: ignore[import-untyped]  # its stubs are not among the dev tools
from playwright.async_api import Error as PlaywrightError
from playwright.async_api import async_playwright

from e2e.harness.chromium import launch_chromium
from e2e.harness.viewer import Viewer

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable

    from playwright.async_api import Browser

    Launch = Callable[[str], Awaitable["Chromium"]]

KEY: Final = "ArrowUp"
_CLOSE_S: Final = 3.0


class Chromium:
    """One browser, one page, the key ahead."""

    def __init__(self, browser: Browser, pid: int, viewer: Viewer) -> None:
        self.viewer = viewer
        self._browser = browser
        self._pid = pid
        self._pids: list[int] = []

    async def press(self) -> None:
        """Release and press again, as required after every fault."""
        await self.let_go()
        await asyncio.sleep(0.08)
        self.find()
        await self.viewer.page.keyboard.down(KEY)

    async def let_go(self) -> None:
        await self.viewer.page.keyboard.up(KEY)

    def freeze(self) -> None:
        """SIGSTOP to all of its processes, including the network's."""
        self._signal(signal.SIGSTOP)

    def thaw(self) -> None:
        self._signal(signal.SIGCONT)

    def kill(self) -> None:
        """SIGKILL to all of its processes."""
        self._signal(signal.SIGKILL)

    async def close(self) -> None:
        """Close whatever is left of it; safe after `freeze` and `kill`."""
        self.thaw()
        with suppress(PlaywrightError, TimeoutError):
            async with asyncio.timeout(_CLOSE_S):
                await self._browser.close()

    def find(self) -> None:
        """Find its processes before they are signalled, because that takes a while."""
        children = psutil.Process(self._pid).children(recursive=True)
        self._pids = [self._pid, *(child.pid for child in children)]

    def _signal(self, how: signal.Signals) -> None:
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
            viewer = await Viewer.prepare(await browser.new_context(), url)
            await viewer.page.goto(url)
            await viewer.sees_picture()
            opened.append(Chromium(browser, pid, viewer))
            return opened[-1]

        try:
            yield launch
        finally:
            for one in opened:
                await one.close()
