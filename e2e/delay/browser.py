"""The browser that watches: Chromium at the link's browser end, with a sound device of its own."""

from __future__ import annotations

from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING, Final

from playwright.async_api import Error, async_playwright

from e2e.delay.systems.served import origin
from e2e.harness.chromium import chromium_at
from e2e.measure.ear import Ear, open_ear
from e2e.measure.errors import MeasureError
from e2e.peers.sizes import VGA

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from playwright.async_api import Browser as Playing
    from playwright.async_api import Page

    from e2e.link import Link
    from e2e.peers.sizes import Size

LOAD_WITHIN_MS: Final = 120_000.0
"""A page of some 100 kB takes a modem half a minute."""

_SHOWN: Final = """
    Math.max(...[...document.querySelectorAll("video")].map((one) => {
      const { width, height } = one.getBoundingClientRect();
      return Math.min(width / %d, height / %d);
    }))
"""
"""How much the largest picture is enlarged."""
_FITS: Final = 0.01
_FITTINGS: Final = 4


class Browser:
    """One process with many windows, each visible to itself, and one sound device, `ear`."""

    def __init__(self, browser: Playing, ear: Ear) -> None:
        self._browser = browser
        self.ear = ear

    async def cpu_s(self) -> float:
        session = await self._browser.new_browser_cdp_session()
        told = await session.send("SystemInfo.getProcessInfo")
        await session.detach()
        return float(sum(process["cpuTime"] for process in told["processInfo"]))

    @asynccontextmanager
    async def window(self, preload: str, size: Size = VGA) -> AsyncIterator[Page]:
        """Open a page with no cookies or cache; `preload` runs in it before its own scripts.

        It has room for a picture of this size.
        """
        # With the microphone allowed, Chromium offers its address. Otherwise it offers a name to be
        # resolved by multicast, which a server without WAX's remedy tries in vain for a second.
        width, height = size.window
        context = await self._browser.new_context(
            bypass_csp=True,
            locale="en-GB",
            permissions=["microphone"],
            viewport={"width": width, "height": height},
        )
        context.set_default_navigation_timeout(LOAD_WITHIN_MS)
        try:
            await context.add_init_script(preload)
            yield await context.new_page()
        finally:
            with suppress(Error):  # a browser that has ended has no windows either
                await context.close()


async def fit(page: Page, size: Size) -> None:
    """Resize the window until its page shows the picture at its own size, as all systems do.

    Without a graphics card a browser spends more on enlarging a picture than on all else; what is
    compared is not whose page fills the window. Raises `MeasureError` if it cannot be done.
    """
    for _ in range(_FITTINGS):
        enlarged = float(await page.evaluate(_SHOWN % (size.width, size.height)))
        if abs(enlarged - 1) < _FITS:
            return
        width, height = size.window
        if page.viewport_size is not None:
            width, height = page.viewport_size["width"], page.viewport_size["height"]
        taller = height + round(size.height * (1 - enlarged))
        await page.set_viewport_size({"width": width, "height": taller})
    raise MeasureError("the page shows the picture enlarged or reduced, whatever its window")


@asynccontextmanager
async def open_browser(link: Link, *flags: str) -> AsyncIterator[Browser]:
    """Run it inside the block: the link's server is secure to it, and sound needs no touch.

    Raises `NotRunError` or `MeasureError`.
    """
    secure = f"--unsafely-treat-insecure-origin-as-secure={origin(link)}"
    known = [link.server.address]
    async with (
        open_ear() as ear,
        async_playwright() as playwright,
        chromium_at(link.browser, playwright, known, secure, *flags, ear=ear) as browser,
    ):
        yield Browser(browser, ear)
