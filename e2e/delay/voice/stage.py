"""A browser whose microphone hears words, and a robot with a speaker, at the ends of a link."""

from __future__ import annotations

import asyncio
import json
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import urlsplit

from e2e.delay.browser import open_browser
from e2e.delay.cell import Cell
from e2e.delay.systems.served import STATE
from e2e.delay.systems.wax import start
from e2e.harness import speech
from e2e.harness.wait import eventually
from e2e.link import Link
from e2e.measure.ear import open_ear
from wax.access import host_link

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from playwright.async_api import Page

    from e2e.delay.browser import Browser
    from e2e.delay.systems.wax import Wax
    from e2e.measure.ear import Ear

SPOKEN_S: Final = 12.0
"""After this the words start over."""
_PRELOAD: Final = Path(__file__).with_name("page.js").read_text(encoding="utf-8")
_SEES_WITHIN_S: Final = 60.0


@dataclass(frozen=True, slots=True)
class Stage:
    """`ear` records what the robot's speaker plays; `window` is the operator's page.

    `state` is the server's folder, in which its user finds the host's link.
    """

    browser: Browser
    window: Page
    system: Wax
    ear: Ear
    state: Path

    @asynccontextmanager
    async def host(self) -> AsyncIterator[Page]:
        """Open the host's page in the same browser, in addition to the operator's."""
        link, *_ = await asyncio.to_thread(host_link.request_links, self.state)
        async with self.browser.window(_preload(listens=False)) as window:
            await window.goto(f"{self.system.url}#{urlsplit(link).fragment}")
            await _sees(window)
            yield window

    async def taken(self) -> dict[str, Any]:
        """Return what the page heard and pinged since the last call, as ``page.js`` keeps it."""
        # As text, which is transferred sooner than so many values.
        found: dict[str, Any] = json.loads(
            await self.window.evaluate("JSON.stringify(waxVoice.take())")
        )
        return found


@asynccontextmanager
async def staged(
    profile: str, *, listens: bool = False, pauses: bool = True
) -> AsyncIterator[Stage]:
    """Open the operator's page, for a turn that outlasts the stage; nothing is held.

    With `listens` it records what its microphone hears. Without `pauses` the words have none.
    Raises `NotRunError` or `MeasureError`.
    """
    cell = Cell(experiment="G", profile=profile, system="operator")
    with TemporaryDirectory(prefix="wax-voice-") as name:
        folder = Path(name)
        words = folder / "words.wav"
        speech.write(words, speech.voice(SPOKEN_S) if pauses else speech.unbroken(SPOKEN_S))
        said = ("--use-fake-device-for-media-stream", f"--use-file-for-fake-audio-capture={words}")
        async with (
            Link(profile) as link,
            open_ear() as robots,
            start(cell, link, folder, robots.variables, voice={"speaker": "speaker"}) as system,
            open_browser(link, *said) as browser,
            browser.window(_preload(listens=listens)) as window,
        ):
            await window.goto(system.url)
            await _sees(window)
            await system.opened(window)
            yield Stage(browser, window, system, robots, folder / STATE / "wax")


def _preload(*, listens: bool) -> str:
    return f"const LISTENS = {str(listens).lower()};\n{_PRELOAD}"


async def _sees(window: Page) -> None:
    await eventually(
        lambda: window.evaluate("waxVoice.sees()"), "there is a picture", within_s=_SEES_WITHIN_S
    )
