"""A page that watches, with the lab's instrument in it: what it shows, sounds, says, and when."""

from __future__ import annotations

import time
from contextlib import AsyncExitStack, asynccontextmanager
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal

from playwright.async_api import async_playwright

from e2e.harness.chromium import launch_chromium
from e2e.harness.viewer import Viewer
from e2e.harness.wait import eventually
from e2e.instrument import PRELOAD, Instrument
from e2e.instrument.sums import shown_ms
from e2e.measure.ear import open_ear
from e2e.measure.errors import MeasureError
from wax.clock import SystemClock

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Sequence

    from playwright.async_api import Browser, WebSocket

    from e2e.delay.readings import Readings
    from e2e.measure.ear import Ear

Place = Literal["room", "server"]

_SCRIPT: Final = Path(__file__).with_name("page.js")
_OPENS_S: Final = 20.0


def now_ms() -> float:
    """Return Unix time, which pages, cards and the ear have too."""
    return time.monotonic() * 1000 + _AHEAD_MS


def unix_ms(monotonic_s: float) -> float:
    """Convert a time of this machine's `time.monotonic`."""
    return monotonic_s * 1000 + _AHEAD_MS


_AHEAD_MS: Final = SystemClock().wall_ms() + 0.5 - time.monotonic() * 1000


class Page:
    """One page; every time that it returns is Unix ms."""

    def __init__(self, viewer: Viewer, ear: Ear) -> None:
        self.viewer = viewer
        self.instrument = Instrument(viewer.page.evaluate, ear)
        self._sockets: list[WebSocket] = []
        viewer.page.on("websocket", self._enters)

    @property
    def room_url(self) -> str:
        """The address of the room that it entered last; raises `MeasureError` if it is in none."""
        found = [one.url for one in self._sockets if not one.is_closed()]
        if not found:
            raise MeasureError("the page is in no room")
        return found[-1]

    def _enters(self, socket: WebSocket) -> None:
        self._sockets.append(socket)

    async def shows(self, place: Place) -> None:
        """Wait until it shows the picture of a room, or of the robot's own server."""

        async def is_there() -> bool:
            places = await self.places()
            return bool(places) and places[-1][1] == place

        await eventually(is_there, f"the page shows the picture of the {place}", within_s=_OPENS_S)

    async def connects(self) -> None:
        """Wait until it says that it is connected."""
        await eventually(self.viewer.says_connected, "the page is connected", within_s=_OPENS_S)

    async def goes_on(self) -> None:
        """Wait until it shows a picture that is newer than this call."""
        from_ms = now_ms()

        async def is_newer() -> bool:
            shown_ms = pictures_ms(await self.readings())
            return bool(shown_ms) and shown_ms[-1] > from_ms

        await eventually(is_newer, "the page shows new pictures", within_s=2 * _OPENS_S)

    async def readings(self) -> Readings:
        """Return all that was shown and heard since it was opened."""
        return await self.instrument.readings()

    async def places(self) -> list[tuple[float, Place]]:
        """Return when whose picture came on the screen."""
        places: list[tuple[float, Place]] = await self.viewer.page.evaluate("waxPage.places")
        return places

    async def said(self, what: Literal["status", "turn"]) -> list[tuple[float, str]]:
        """Return each text of the status line, or about the turn, and since when it was there."""
        said: list[tuple[float, str]] = await self.viewer.page.evaluate(f"waxPage.said.{what}")
        return said


class Browsers:
    """Opens pages; each `loud` one has a browser and a sound device of its own."""

    def __init__(
        self, launch: Callable[[Ear], Awaitable[Browser]], leaving: AsyncExitStack
    ) -> None:
        self._launch = launch
        self._leaving = leaving
        self._shared: tuple[Browser, Ear] | None = None

    async def prepare(self, url: str, *, loud: bool = False) -> Page:
        """Make a page, still empty; raises `NotRunError` where nothing can be heard."""
        if loud or self._shared is None:
            ear = await self._leaving.enter_async_context(open_ear())
            made = await self._launch(ear), ear
            if not loud:
                self._shared = made
        else:
            made = self._shared
        browser, ear = made
        context = await browser.new_context(locale="en-GB")
        await context.add_init_script(PRELOAD)
        await context.add_init_script(path=_SCRIPT)
        return Page(Viewer(await context.new_page(), url, ear), ear)

    async def open(self, url: str, *, loud: bool = False) -> Page:
        """Open the robot's page, wait for its picture, and have it sound."""
        page = await self.prepare(url, loud=loud)
        await page.viewer.page.goto(url)
        await eventually(page.instrument.sees_picture, "there is a picture", within_s=_OPENS_S)
        await page.connects()
        await page.viewer.button("Turn sound on").click()
        return page


@asynccontextmanager
async def browsers() -> AsyncIterator[Browsers]:
    """Have Chromium inside the block."""
    async with async_playwright() as playwright, AsyncExitStack() as leaving:

        async def launch(ear: Ear) -> Browser:
            browser = await launch_chromium(playwright, ear=ear)
            leaving.push_async_callback(browser.close)
            return browser

        yield Browsers(launch, leaving)


def longest_gap_ms(times_ms: Sequence[float], from_ms: float, to_ms: float) -> float:
    """Return the longest time without any of these; what stood at an edge is counted from before.

    Raises `MeasureError` where there was nothing before the first edge or after the last one.
    """
    begin = max((at for at in times_ms if at <= from_ms), default=None)
    end = min((at for at in times_ms if at >= to_ms), default=None)
    if begin is None or end is None:
        raise MeasureError("nothing was seen before or after; the gap has no end")
    inside = [at for at in times_ms if begin <= at <= end]
    return max(after - before for before, after in pairwise(inside)) if len(inside) > 1 else 0.0


def pictures_ms(readings: Readings) -> list[float]:
    """Return when each new picture was shown."""
    return shown_ms(readings.pictures)
