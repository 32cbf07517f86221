"""``python -m e2e.gallery``: photograph every state of the page in every window and theme.

Exit status: 0 when every state was reached, else 1; 2 for a state that there is not.
"""

from __future__ import annotations

import argparse
import asyncio
import sys
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Final

from playwright.async_api import Error, async_playwright

from e2e.gallery.shots import shoot, write_page
from e2e.gallery.states import STATES, named
from e2e.gallery.views import ACROSS, DESKTOP, DEVICES, UPRIGHT, View
from e2e.harness.chromium import launch_chromium
from e2e.measure.suite import ROOT

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.gallery.states import State

SCREENSHOTS: Final = ROOT / "web/screenshots"
README: Final = {
    "desktop.jpg": View(DESKTOP, "light"),
    "phone.jpg": View(UPRIGHT, "dark"),
    "phone-across.jpg": View(ACROSS, "dark"),
}
"""The README's pictures, all of somebody who drives."""
_QUALITY: Final = 85


async def gallery(states: Sequence[State]) -> dict[str, str]:
    """Photograph these states; return why by the key of each that was not reached."""
    problems: dict[str, str] = {}
    async with async_playwright() as playwright, await launch_chromium(playwright) as browser:
        for state in states:
            print(f"{state.key} … ", end="", flush=True)
            try:
                for device in DEVICES:
                    async with state.reached(browser, device) as scene:
                        for view in device.views:
                            await view.show(scene.viewer.page)
                            await shoot(scene, state, view)
            except (AssertionError, Error) as error:
                problems[state.key] = " ".join(str(error).split())[:300]
            print(problems.get(state.key, "ok"))
    return problems


async def readme() -> None:
    async with async_playwright() as playwright, await launch_chromium(playwright) as browser:
        for name, view in README.items():
            async with named("driving").reached(browser, view.device) as scene:
                page = scene.viewer.page
                await view.show(page)
                await page.screenshot(path=SCREENSHOTS / name, type="jpeg", quality=_QUALITY)


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m e2e.gallery", description=__doc__)
    parser.add_argument("--only", nargs="+", metavar="STATE", help="these; * and ? as in a shell")
    parser.add_argument("--list", action="store_true", help="say which states there are")
    parser.add_argument("--readme", action="store_true", help="only the README's three pictures")
    arguments = parser.parse_args()
    patterns = arguments.only or ["*"]
    states = [one for one in STATES if any(fnmatchcase(one.key, each) for each in patterns)]
    if not states:
        print(f"gallery: no state is called {' or '.join(patterns)}; see --list", file=sys.stderr)
        return 2
    if arguments.list:
        print("\n".join(f"{state.key:<20}{state.title}" for state in states))
        return 0
    if arguments.readme:
        asyncio.run(readme())
        return 0
    problems = asyncio.run(gallery(states))
    print(write_page(problems))
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
