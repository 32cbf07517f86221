"""Run in a network namespace of its own: server and browser on a machine with only a loopback.

``python -m e2e.harness.alone FOLDER`` reads the test card in Chromium and prints how many of its
pictures were whole.
"""

from __future__ import annotations

import asyncio
import sys
from pathlib import Path

from playwright.async_api import async_playwright

from e2e.harness import toml
from e2e.harness.chromium import launch_chromium
from e2e.harness.server import Server
from e2e.harness.viewer import Viewer

LOOPBACK_FLAGS = (
    "--allow-loopback-in-peer-connection",
    "--disable-features=WebRtcHideLocalIpsWithMdns",
)
"""Of itself Chromium 156 makes no connection where there is no network: it wants to announce a name
for its address by multicast DNS first, which no interface carries.
"""


async def watch(folder: Path) -> int:
    """Count the whole pictures among thirty presented ones."""
    async with (
        Server(folder, toml.CARD) as server,
        async_playwright() as playwright,
        await launch_chromium(playwright, *LOOPBACK_FLAGS) as browser,
    ):
        viewer = await Viewer.at(await browser.new_context(), server.url)
        await viewer.sees_picture()
        return sum(card.valid for card in await viewer.cards(30))


if __name__ == "__main__":
    print(asyncio.run(watch(Path(sys.argv[1]))))
