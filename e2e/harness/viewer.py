"""One viewer at one browser window, with its video probe, its ear and its controls."""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from playwright.async_api import Error

from e2e.harness.installed import needed
from e2e.harness.wait import eventually, happens

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from playwright.async_api import BrowserContext, FloatRect, Locator, Page, Route

    from e2e.measure.ear import Block, Ear, Tap

PROBE = Path(__file__).with_name("probe.js")
BLACK = 16
OWN, BROWSER = "WAX's own", "the browser's"
"""The two sound players, as the details name them."""
LEAVE = re.compile(r"^(Leave the queue|End my turn)$")


async def box_of(locator: Locator) -> FloatRect:
    """Return an element's place in the window; raises `AssertionError` if it is not shown."""
    box = await locator.bounding_box()
    assert box is not None, f"{locator} is not shown"
    return box


@dataclass(frozen=True, slots=True)
class Card:
    """One presented frame of the test card; `age_ms` is by the wall clock."""

    stamp_ms: int
    valid: bool
    age_ms: float
    now_ms: float
    width: int
    height: int


class Viewer:
    """A page with the video probe in it, whose browser plays to `ear`.

    Controls are found by role and accessible name only.
    """

    def __init__(self, page: Page, url: str, ear: Ear | None) -> None:
        self.page = page
        self._ear = ear
        self._tap: Tap | None = None
        self.url = url
        self.console: list[str] = []
        self.errors: list[str] = []
        page.on("console", lambda message: self.console.append(f"{message.type}: {message.text}"))
        page.on("pageerror", lambda error: self.errors.append(str(error)))

    @classmethod
    async def prepare(cls, context: BrowserContext, url: str, ear: Ear | None = None) -> Viewer:
        """Make a page with the instruments in it, still empty."""
        await context.add_init_script(path=PROBE)
        return cls(await context.new_page(), url, ear)

    @classmethod
    async def at(cls, context: BrowserContext, url: str, ear: Ear | None = None) -> Viewer:
        """Open the page at an address."""
        viewer = await cls.prepare(context, url, ear)
        await viewer.page.goto(url)
        return viewer

    # --- the controls ---------------------------------------------------------------------

    def button(self, name: str | re.Pattern[str]) -> Locator:
        return self.page.get_by_role("button", name=name, exact=True)

    def switch(self, name: str) -> Locator:
        return self.page.get_by_role("switch", name=name, exact=True)

    def speed(self, name: str) -> Locator:
        group = self.page.get_by_role("group", name="Speed", exact=True)
        return group.get_by_role("button", name=name, exact=True)

    @property
    def joystick(self) -> Locator:
        """What a finger or the mouse pushes in the direction in which the robot should go."""
        return self.page.get_by_label("Joystick", exact=True).first

    @property
    def name(self) -> Locator:
        return self.page.get_by_role("textbox", name="Your name", exact=True)

    async def open(self, panel: str) -> None:
        """Open a panel by its tab: People, Settings, Details, Safety, or the host's."""
        tab = self.button(panel)
        if await tab.get_attribute("aria-expanded") == "false":
            await tab.click()

    async def drive_by(self, control: str) -> None:
        """Choose Joystick or Buttons on the screen, whatever the pointer."""
        await self.open("Settings")
        choice = self.page.get_by_role("combobox", name="On the screen", exact=True)
        await choice.select_option(label=control)

    async def call_oneself(self, name: str) -> None:
        await self.name.fill(name)
        await self.name.press("Enter")

    async def join(self) -> None:
        await self.button("Join the queue").click()

    async def leave(self) -> None:
        """Give up the place in the queue, or the turn."""
        await self.page.get_by_role("button", name=LEAVE).click()

    async def release_stop(self) -> None:
        """Hold the button that releases the stop; again if a busy machine made it refused."""
        release, keys = self.button("Hold to release"), self.page.keyboard

        async def is_released() -> bool:
            if await release.is_hidden():
                return True
            await release.focus()  # the mouse would miss it if the page moves meanwhile
            await keys.down("Enter")
            is_hidden = await happens(release.is_hidden, within_s=3.0)
            await keys.up("Enter")
            return is_hidden

        await release.wait_for()
        await eventually(is_released, "the stop is released")

    async def drives(self, within_s: float = 20) -> None:
        await self.page.get_by_text("You are driving").first.wait_for(
            state="visible", timeout=within_s * 1000
        )

    async def takes_the_wheel(self, within_s: float = 20) -> None:
        await self.join()
        await self.drives(within_s)

    async def leaves(self) -> None:
        """Leave turn or queue, if the page is still open and has such a button."""
        leave = self.page.get_by_role("button", name=LEAVE)
        with suppress(Error):
            if await leave.is_visible():
                await leave.click(timeout=1000)

    async def says_connected(self) -> bool:
        """Return the page's status of the connection."""
        text = await self.page.get_by_role("status").first.inner_text()
        return text.strip().lower().startswith("connected")

    async def is_reached_as(self, name: str) -> None:
        """Make an address for visitors lead to the server, as a name server does."""

        async def through(route: Route) -> None:
            url = route.request.url.replace(name, self.url)
            headers = {**route.request.headers, "origin": self.url}
            with suppress(Error):  # the page may close meanwhile
                await route.fulfill(response=await route.fetch(url=url, headers=headers))

        await self.page.route(f"{name}/**", through)

    # --- what is opened and put away --------------------------------------------------------

    async def details_say(self, words: str, within_s: float = 20) -> None:
        """Open the details, and wait until they say this."""

        async def say() -> bool:
            await self.open("Details")
            return words in await self.page.evaluate("document.body.textContent")

        await eventually(say, f"the details say “{words}”", within_s=within_s)

    async def puts_the_first_card_away(self) -> None:
        """Close the card that greets newcomers, if it is there."""
        card = self.page.get_by_role("region", name="Welcome", exact=True)
        if await card.is_visible():
            await card.get_by_role("button").last.click()

    async def closes(self, panel: str) -> None:
        """Close a panel by its tab, so that nothing in it has the focus."""
        tab = self.button(panel)
        if await tab.get_attribute("aria-expanded") == "true":
            await tab.click()

    async def lies_still(self) -> None:
        """Wait until everything on the page has its place, which takes some frames."""
        await self.probe("liesStill()")

    async def resize(self, width: int, height: int) -> None:
        """Resize the page to so many pixels, and wait until its layout is stable."""
        await self.page.set_viewport_size({"width": width, "height": height})
        await self.lies_still()

    # --- the video probe ------------------------------------------------------------------

    async def probe(self, expression: str) -> Any:
        return await self.page.evaluate(f"window.waxProbe.{expression}")

    async def sees_picture(self, within_s: float = 30) -> None:
        await eventually(lambda: self.probe("playing()"), "the picture plays", within_s=within_s)

    async def is_dark(self) -> bool:
        """Return whether nothing in the picture is brighter than black."""
        return bool(await self.probe("luma()") <= BLACK)

    async def cards(self, count: int = 10, at: int = 0) -> list[Card]:
        """Read the test card off the next `count` presented frames.

        `at` 0 is the driving view; the other cameras count from 1.
        """
        return [Card(**card) for card in await self.probe(f"cards({count}, {at})")]

    async def inbound(self, kind: str) -> dict[str, Any]:
        """Return the browser's statistics of one incoming stream, empty without one."""
        return await self.probe(f"inbound('{kind}')") or {}

    async def packets(self, kind: str) -> int:
        return int((await self.inbound(kind)).get("packetsReceived", 0))

    async def receives_more(self, kind: str) -> None:
        """Wait until further packets of this stream have come."""
        before = await self.packets(kind)

        async def more() -> bool:
            return await self.packets(kind) > before

        await eventually(more, f"the {kind} goes on")

    # --- the ear --------------------------------------------------------------------------

    async def listen(self) -> None:
        """Turn the sound on if it is off, and wait until the browser plays."""
        self._tap = needed(self._ear).tap(records=True)
        button = self.button("Turn sound on")
        if await happens(button.is_visible, within_s=5):  # a page offers it once it is connected
            await button.click()
        else:
            for switch in await self.switch("Sound").all():
                if await switch.get_attribute("aria-checked") == "false":
                    await switch.click()
        assert await self._tap.hears(within_s=20), "nothing sounds"

    def heard(self) -> list[Block]:
        """Everything that the browser has played since `listen` or `forget`."""
        return [] if self._tap is None else list(self._tap.heard)

    def sound(self) -> NDArray[np.int16]:
        """Return the samples of `heard`, mono."""
        return np.asarray(self.ears().mean(axis=1), np.int16)

    def ears(self) -> NDArray[np.int16]:
        """Return the samples of `heard` as ``(n, 2)``, the left ear first."""
        recorded = [] if self._tap is None else self._tap.recorded or []
        return np.asarray(np.concatenate([np.zeros((0, 2)), *recorded]) * 32767, np.int16)

    def forget(self) -> None:
        if self._tap is not None:
            self._tap = needed(self._ear).tap(records=True)


async def plays_by(viewer: Viewer, player: str) -> None:
    await viewer.details_say(f"Sound player{player}")
