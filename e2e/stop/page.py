"""A viewer in a Chromium of their own, whose processes can be frozen and killed."""

from __future__ import annotations

import asyncio
import os
import signal
import time
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING, Any, Final

import psutil  # type: ignore[import-untyped]  # its stubs are not among the dev tools
from playwright.async_api import Error as PlaywrightError
from playwright.async_api import async_playwright

from e2e.harness.chromium import launch_chromium
from e2e.harness.page_clock import page_clock
from e2e.harness.viewer import Card, Viewer
from e2e.measure.errors import MeasureError
from e2e.stop.relay import without_candidates
from wax.clock import SystemClock

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable

    from playwright.async_api import Browser, Page, Route

    from e2e.stop.relay import Relay

    Launch = Callable[..., Awaitable["Chromium"]]
    Prepare = Callable[[Page], Awaitable[None]]

KEY: Final = "ArrowUp"
_CLOSE_S: Final = 3.0

_NOTES: Final = """() => {
    if (!window.waxNotes) {
        const note = () => window.waxNotes.push([performance.now(), document.body.innerText]);
        const options = { subtree: true, childList: true, characterData: true, attributes: true };
        new MutationObserver(note).observe(document.body, options);
    }
    window.waxNotes = [];
}"""
"""Notes the page's text whenever it changes."""

_LOOK: Final = """() => {
    const look = async () => {
        const [card] = await window.waxProbe.cards(1);
        if (card.valid) window.waxNewest = card;
        void look();
    };
    window.waxNewest = null;
    void look();
}"""
"""Notes the test card of each presented picture."""


class Chromium:
    """One browser, one page, the key ahead."""

    def __init__(self, browser: Browser, pid: int, viewer: Viewer) -> None:
        self.viewer = viewer
        self._browser = browser
        self._pid = pid
        self._pids: list[int] = []

    async def take_the_wheel(self) -> None:
        await self.viewer.join()
        await self.viewer.drives(15)

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

    async def take_notes(self) -> None:
        """Start noting the page's text, and forget earlier text."""
        await self.viewer.page.evaluate(_NOTES)

    async def reads(self, text: str, within_s: float = 5.0) -> float:
        """Return when the text appeared on the page, on CLOCK_MONOTONIC."""
        page = self.viewer.page
        await page.get_by_text(text).first.wait_for(state="visible", timeout=within_s * 1000)
        notes = await page.evaluate("window.waxNotes")
        at_ms = next((at_ms for at_ms, shown in notes if text in shown), None)
        if at_ms is None:
            raise MeasureError(f"the page shows, but was not seen to begin to show: {text}")
        return await self.monotonic_s(at_ms)

    async def look(self) -> None:
        """Start noting the pictures that the page shows."""
        await self.viewer.page.evaluate(_LOOK)

    async def newest_s(self) -> float:
        """Return the capture time of the newest picture shown, on CLOCK_MONOTONIC."""
        newest = await self.viewer.page.evaluate("window.waxNewest")
        if newest is None:
            raise MeasureError("the page has shown no picture since it was looked at")
        card = Card(**newest)
        taken_ms = card.now_ms - card.age_ms
        return time.monotonic() - (SystemClock().wall_ms() - taken_ms) / 1000

    async def monotonic_s(self, page_ms: float) -> float:
        """Turn the page's `performance.now` into CLOCK_MONOTONIC."""
        return (await page_clock(self.viewer.page.evaluate)).monotonic_s(page_ms)

    async def close(self) -> None:
        """Close whatever is left of it; safe after `kill`."""
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


def through(relay: Relay) -> Prepare:
    """Prepare a page whose connection goes through a relay."""

    async def exchange(route: Route) -> None:
        asked: dict[str, Any] = route.request.post_data_json or {}
        response = await route.fetch(post_data=asked | {"sdp": without_candidates(asked["sdp"])})
        told = await response.json()
        if response.ok:
            told["sdp"] = await relay.answer(told["sdp"])
        await route.fulfill(response=response, json=told)  # with the cookie that comes with it

    async def prepare(page: Page) -> None:
        await page.route("**/api/offer", exchange)

    return prepare


@asynccontextmanager
async def chromiums() -> AsyncIterator[Launch]:
    """Yield a function that opens a page in a browser of its own; all are closed at the end.

    Its `prepare` is done to the page before that is loaded.
    """
    opened: list[Chromium] = []
    async with async_playwright() as playwright:

        async def launch(url: str, *, prepare: Prepare | None = None, **options: Any) -> Chromium:
            browser = await launch_chromium(playwright)
            session = await browser.new_browser_cdp_session()
            info = (await session.send("SystemInfo.getProcessInfo"))["processInfo"]
            pid = next(int(one["id"]) for one in info if one["type"] == "browser")
            viewer = await Viewer.prepare(await browser.new_context(**options), url)
            if prepare is not None:
                await prepare(viewer.page)
            await viewer.page.goto(url)
            await viewer.sees_picture()
            opened.append(Chromium(browser, pid, viewer))
            return opened[-1]

        try:
            yield launch
        finally:
            for one in opened:
                await one.close()
