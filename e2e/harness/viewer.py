"""One viewer at one browser window, with its video probe, audio probe and controls."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from playwright.async_api import BrowserContext, Locator, Page

HERE = Path(__file__).parent

LISTENING: Final = {"bypass_csp": True}
"""Options of a context with the audio probe, whose script the page's own policy rightly refuses."""


@dataclass(frozen=True, slots=True)
class Card:
    """One presented frame of the test card; `age_ms` is by the wall clock."""

    stamp_ms: int
    valid: bool
    age_ms: float
    now_ms: float
    width: int
    height: int


@dataclass(frozen=True, slots=True)
class Block:
    """10 ms of played sound: Unix time in ms, loudness, amplitudes of the card's two tones."""

    start_ms: float
    rms: float
    tone: float
    burst: float


class Viewer:
    """A page with the probes in it; controls are found by role and accessible name only."""

    def __init__(self, page: Page, url: str) -> None:
        self.page = page
        self.url = url
        self.console: list[str] = []
        self.errors: list[str] = []
        page.on("console", lambda message: self.console.append(f"{message.type}: {message.text}"))
        page.on("pageerror", lambda error: self.errors.append(str(error)))

    @classmethod
    async def prepare(cls, context: BrowserContext, url: str) -> Viewer:
        """Make a page with the instruments in it, still empty."""
        await context.add_init_script(path=HERE / "probe.js")
        return cls(await context.new_page(), url)

    # --- the controls ---------------------------------------------------------------------

    def button(self, name: str) -> Locator:
        return self.page.get_by_role("button", name=name, exact=True)

    def switch(self, name: str) -> Locator:
        return self.page.get_by_role("switch", name=name, exact=True)

    def radio(self, name: str) -> Locator:
        group = self.page.get_by_role("radiogroup", name="Speed", exact=True)
        return group.or_(self.page.get_by_role("group", name="Speed", exact=True)).get_by_role(
            "radio", name=name, exact=True
        )

    @property
    def size(self) -> Locator:
        return self.page.get_by_role("combobox", name="Picture size", exact=True)

    @property
    def timing(self) -> Locator:
        return self.page.get_by_role("combobox", name="Timing", exact=True)

    @property
    def name(self) -> Locator:
        return self.page.get_by_role("textbox", name="Your name", exact=True)

    @property
    def queue(self) -> Locator:
        return self.page.get_by_role("list", name="Queue", exact=True)

    @property
    def timer(self) -> Locator:
        return self.page.get_by_role("timer")

    async def call_oneself(self, name: str) -> None:
        await self.name.fill(name)
        await self.name.press("Enter")

    async def join(self) -> None:
        await self.button("Join the queue").click()

    async def leave(self) -> None:
        await self.button("Leave the queue").click()

    async def release_stop(self) -> None:
        """Hold the button that releases the stop for the time that it requires."""
        release = self.button("Hold to release")
        await release.hover()
        await self.page.mouse.down()
        await release.wait_for(state="hidden", timeout=3000)
        await self.page.mouse.up()

    async def drives(self, within_s: float = 10) -> None:
        """Wait until the page says that this viewer drives."""
        await self.page.get_by_text("You are driving").first.wait_for(
            state="visible", timeout=within_s * 1000
        )

    async def says_connected(self) -> bool:
        """Return the page's status of the connection."""
        text = await self.page.get_by_role("status").first.inner_text()
        return text.strip().lower().startswith("connected")

    # --- the video probe ------------------------------------------------------------------

    async def probe(self, expression: str) -> Any:
        return await self.page.evaluate(f"window.waxProbe.{expression}")

    async def sees_picture(self, within_s: float = 15) -> None:
        async def playing() -> bool:
            return bool(await self.probe("playing()"))

        await eventually(playing, "the picture plays", within_s=within_s)

    async def cards(self, count: int = 10) -> list[Card]:
        """Read the test card off the next `count` presented frames."""
        return [Card(**card) for card in await self.probe(f"cards({count})")]

    async def inbound(self, kind: str) -> dict[str, Any]:
        """Return the browser's statistics of one incoming stream, empty without one."""
        return await self.probe(f"inbound('{kind}')") or {}

    async def packets(self, kind: str) -> int:
        return int((await self.inbound(kind)).get("packetsReceived", 0))

    # --- the audio probe ------------------------------------------------------------------

    async def listen(self) -> None:
        """Press Start if it is offered, and attach the audio probe; needs `LISTENING`."""
        if await self.button("Start").is_visible():
            await self.button("Start").click()

        meter = (HERE / "meter.js").read_text(encoding="utf-8")

        async def hears() -> bool:
            return bool(await self.page.evaluate("window.waxProbe.listen", meter))

        await eventually(hears, "the page plays sound", within_s=10)

    async def heard(self) -> list[Block]:
        """Everything heard since `listen` or `forget`, at most a minute."""
        return [Block(**block) for block in await self.probe("heard()")]

    async def device_ms(self) -> float:
        """Return the browser's own estimate of the delay from audio probe to loudspeaker."""
        playout = await self.probe("playout()")
        return float(playout["totalPlayoutDelay"] / playout["totalSamplesCount"] * 1000)

    async def forget(self) -> None:
        await self.probe("forget()")
