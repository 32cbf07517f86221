"""A page that watches, and records what it shows and says, and when."""

from __future__ import annotations

import time
from contextlib import asynccontextmanager, suppress
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal

from playwright.async_api import async_playwright

from e2e.harness.chromium import launch_chromium
from e2e.harness.page_clock import unix_ms
from e2e.harness.viewer import Viewer
from e2e.harness.wait import eventually
from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Sequence

    from playwright.async_api import WebSocket

    Open = Callable[[str], Awaitable["Page"]]

Place = Literal["room", "server"]

_SCRIPT: Final = Path(__file__).with_name("page.js")
_OPENS_S: Final = 20.0


def now_ms() -> float:
    """Return Unix time, which pages use too."""
    return unix_ms(time.monotonic())


class Page:
    """One page; every time that it returns is Unix ms."""

    def __init__(self, viewer: Viewer) -> None:
        self.viewer = viewer
        self._sockets: list[WebSocket] = []
        viewer.page.on("websocket", self._opened)

    def _opened(self, socket: WebSocket) -> None:  # Playwright accepts no builtin method
        self._sockets.append(socket)

    @property
    def room_url(self) -> str:
        """The address of the room that it entered last; raises `MeasureError` if it is in none."""
        found = [one.url for one in self._sockets if not one.is_closed()]
        if not found:
            raise MeasureError("the page is in no room")
        return found[-1]

    async def shows(self, place: Place) -> None:
        async def is_there() -> bool:
            places = await self.places()
            return bool(places) and places[-1][1] == place

        await eventually(is_there, f"the page shows the picture of the {place}", within_s=_OPENS_S)

    async def goes_on(self) -> None:
        """Wait until it says that it shows a picture, and the picture is newer than this call."""
        from_ms = now_ms()

        async def is_newer() -> bool:
            shown_ms = await self.pictures_ms()
            return bool(shown_ms) and shown_ms[-1] > from_ms

        await eventually(is_newer, "the page shows new pictures", within_s=2 * _OPENS_S)
        await eventually(self.viewer.says_connected, "the page is connected", within_s=_OPENS_S)

    async def pictures_ms(self) -> list[float]:
        found: list[float] = await self.viewer.page.evaluate("waxPage.pictures")
        return found

    async def places(self) -> list[tuple[float, Place]]:
        """Return when a picture of each place came on the screen."""
        found: list[tuple[float, Place]] = await self.viewer.page.evaluate("waxPage.places")
        return found

    async def says(
        self, sentence: str, since_ms: float, within_s: float, where: str = "status"
    ) -> float | None:
        """Return how long after a moment it begins to show a sentence; None for never."""

        async def said() -> list[float]:
            texts = await self.viewer.page.evaluate(f"waxPage.said.{where}")
            return [at_ms for at_ms, text in texts if at_ms >= since_ms and sentence in text]

        with suppress(AssertionError):
            return (await eventually(said, "it says so", within_s=within_s))[0] - since_ms
        return None


@asynccontextmanager
async def pages() -> AsyncIterator[Open]:
    """Run Chromium; yield a function that opens the robot's page and waits for its picture."""
    async with async_playwright() as playwright:
        browser = await launch_chromium(playwright)

        async def open_one(url: str) -> Page:
            context = await browser.new_context(locale="en-GB")
            await context.add_init_script(path=_SCRIPT)
            page = Page(await Viewer.prepare(context, url))
            await page.viewer.page.goto(url)
            await page.viewer.sees_picture(within_s=_OPENS_S)
            await page.goes_on()
            await page.viewer.button("Turn sound on").click()
            return page

        yield open_one
        await browser.close()


def longest_gap_ms(times_ms: Sequence[float], from_ms: float, to_ms: float) -> float:
    """Return the longest time without any of these, counting the last one before `from_ms`.

    Raises `MeasureError` if there was nothing before the first edge or after the last.
    """
    begin = max((at for at in times_ms if at <= from_ms), default=None)
    end = min((at for at in times_ms if at >= to_ms), default=None)
    if begin is None or end is None:
        raise MeasureError("nothing was seen before or after; the gap has no end")
    inside = [at for at in times_ms if begin <= at <= end]
    return max((after - before for before, after in pairwise(inside)), default=0.0)
