"""Chromium at the browser end, driven by Playwright."""

from __future__ import annotations

import json
import os
from contextlib import asynccontextmanager, contextmanager, suppress
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import urlsplit

from playwright.async_api import Error, async_playwright

from e2e.browsers.window import LOAD_WITHIN_S, as_json
from e2e.harness.chromium import FLAGS
from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator, Sequence
    from pathlib import Path

    from playwright.async_api import Browser, Page

    from e2e.browsers.window import Key
    from e2e.link import Link
    from e2e.measure.ear import Ear

START_WITHIN_S: Final = 40.0


class ChromiumWindow:
    def __init__(self, page: Page) -> None:
        self._page = page

    async def goto(self, url: str) -> None:
        with _failing(f"{url} does not open in Chromium"):
            await self._page.goto(url, timeout=LOAD_WITHIN_S * 1000)

    async def evaluate(self, expression: str) -> Any:
        with _failing("a script failed in Chromium"):
            text = await self._page.evaluate(as_json(expression))
        return None if text is None else json.loads(text)

    async def hold(self, key: Key) -> None:
        with _failing(f"{key} cannot be pressed in Chromium"):
            await self._page.keyboard.down(key)

    async def release(self, key: Key) -> None:
        with _failing(f"{key} cannot be let go of in Chromium"):
            await self._page.keyboard.up(key)


class Chromium:
    def __init__(self, browser: Browser, ear: Ear) -> None:
        self._browser = browser
        self.ear = ear

    async def cpu_s(self) -> float | None:
        with _failing("Chromium tells nothing of its processes"):
            session = await self._browser.new_browser_cdp_session()
            told = await session.send("SystemInfo.getProcessInfo")
            await session.detach()
        return float(sum(process["cpuTime"] for process in told["processInfo"]))

    @asynccontextmanager
    async def window(self, preload: str) -> AsyncIterator[ChromiumWindow]:
        # With the microphone allowed Chromium offers its address. Else it offers a name to be
        # asked for by multicast, which a server without WAX's remedy does in vain for a second.
        with _failing("Chromium opens no window"):
            context = await self._browser.new_context(
                bypass_csp=True, locale="en-GB", permissions=["microphone"]
            )
        try:
            with _failing("Chromium opens no window"):
                await context.add_init_script(preload)
                page = await context.new_page()
            yield ChromiumWindow(page)
        finally:
            with suppress(Error):  # a browser that has ended has no windows either
                await context.close()


@asynccontextmanager
async def open_chromium(
    path: str, link: Link, origins: Sequence[str], folder: Path, ear: Ear, *more_flags: str
) -> AsyncIterator[Chromium]:
    """Start it headless; see `e2e.browsers.open_browser`."""
    launcher = link.browser.launcher(folder / "chromium", path)
    known = "".join(f", EXCLUDE {urlsplit(one).hostname}" for one in origins)
    flags = [
        *FLAGS,
        *more_flags,
        "--no-sandbox",
        f"--unsafely-treat-insecure-origin-as-secure={','.join(origins)}",
        # Nobody answers there, and what it asks for would go over the link and be counted.
        f"--host-resolver-rules=MAP * ~NOTFOUND{known}",
    ]
    async with async_playwright() as playwright:
        with _failing("Chromium does not start"):
            browser = await playwright.chromium.launch(
                executable_path=launcher,
                headless=True,
                args=flags,
                ignore_default_args=["--mute-audio"],
                env={**os.environ, **ear.variables},
                timeout=START_WITHIN_S * 1000,
                # Ctrl-C is for us alone: the browser is closed when we are ready.
                handle_sigint=False,
                handle_sigterm=False,
                handle_sighup=False,
            )
        try:
            yield Chromium(browser, ear)
        finally:
            with suppress(Error):
                await browser.close()


@contextmanager
def _failing(what: str) -> Iterator[None]:
    """Let Playwright's error be one sentence."""
    try:
        yield
    except Error as error:
        lines = [line.strip() for line in error.message.splitlines() if line.strip()]
        raise MeasureError(f"{what}: {lines[0] if lines else error.name}") from error
