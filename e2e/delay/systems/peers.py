"""The peers at the server's end: stock aiortc, and LiveKit in both ways (see `e2e.peers`)."""

from __future__ import annotations

import asyncio
import time
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Final

from e2e.delay.systems.running import PORT, Running
from e2e.delay.systems.served import serving
from e2e.measure.errors import MeasureError
from e2e.peers.livekit.installation import check_sdk, find_client, find_server

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from playwright.async_api import Page

    from e2e.delay.cell import Cell
    from e2e.link import Link

_PLAYS_WITHIN_S: Final = 10.0
_LOOK_EVERY_S: Final = 0.1
_PLAY_THE_SOUND: Final = """(() => {
  const sound = document.getElementById("sound");
  if (!sound.hidden) sound.click();
  return sound.hidden ? document.getElementById("state").textContent : "its sound is off";
})()"""
"""Presses the button for sound if there is one, and returns what the page says of itself."""


class LiveKitRunning(Running):
    """LiveKit, a child of the process that publishes and serves the page."""

    async def opened(self, window: Page) -> None:
        """Press the page's button for sound where it has one, until the page is connected."""
        until_s = time.monotonic() + _PLAYS_WITHIN_S
        while (state := await window.evaluate(_PLAY_THE_SOUND)) != "connected":
            if time.monotonic() > until_s:
                raise MeasureError(f"LiveKit's page does not play in time: {state}")
            await asyncio.sleep(_LOOK_EVERY_S)

    async def told(self) -> dict[str, float | str]:
        """Return versions, and how often the publisher had to publish."""
        health = await self._served.json("/healthz")
        return {
            "livekit_server": str(health["server"]),
            "livekit_client": str(health["client"]),
            "published": float(health["published"]),
        }


@asynccontextmanager
async def start(cell: Cell, link: Link, folder: Path) -> AsyncIterator[Running]:
    """See `e2e.delay.systems.start`."""
    if cell.system != "stock":
        check_installed(_how(cell))
    arguments = command(cell, link.server.address)
    async with serving(cell.system, link.server, folder, arguments) as served:
        yield Running(served) if cell.system == "stock" else LiveKitRunning(served)


def check_installed(how: str) -> None:
    """Raise `NotRunError` when LiveKit's server, its browser library or its SDK is missing."""
    find_server()
    find_client()
    if how == "sdk":
        check_sdk()


def command(cell: Cell, address: str) -> list[str]:
    """Return Python's arguments."""
    place = ["--port", str(PORT), "--host"]
    if cell.system == "stock":
        return ["-m", "e2e.peers.stock", *place, "0.0.0.0"]
    return ["-m", "e2e.peers.livekit", "--how", _how(cell), *place, address]


def _how(cell: Cell) -> str:
    return "whip" if cell.system == "livekit-whip" else "sdk"
