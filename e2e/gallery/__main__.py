"""``python -m e2e.gallery``: retake the READMEs' pictures, all of a page that drives."""

from __future__ import annotations

import asyncio
from typing import Final

from playwright.async_api import async_playwright

from e2e.gallery.states import named
from e2e.gallery.turn import record
from e2e.gallery.views import ACROSS, UPRIGHT, View
from e2e.harness.chromium import launch_chromium
from e2e.measure.suite import ROOT

SCREENSHOTS: Final = ROOT / "web/screenshots"
README: Final = {
    "phone.jpg": View(UPRIGHT, "dark"),
    "phone-across.jpg": View(ACROSS, "dark"),
}
_QUALITY: Final = 85


async def main() -> None:
    async with async_playwright() as playwright, await launch_chromium(playwright) as browser:
        await record(browser, SCREENSHOTS / "turn.webp")
        for name, view in README.items():
            async with named("driving").reached(browser, view.device) as scene:
                page = scene.viewer.page
                await view.show(page)
                await page.screenshot(path=SCREENSHOTS / name, type="jpeg", quality=_QUALITY)


if __name__ == "__main__":
    asyncio.run(main())
