"""LiveKit at the server's end, published in either way that `e2e.peers.livekit` has."""

from __future__ import annotations

import asyncio
import time
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Final

from e2e.lab.systems.film import film
from e2e.lab.systems.running import PORT
from e2e.lab.systems.served import serving
from e2e.measure.errors import MeasureError, NotRunError
from e2e.peers.livekit.errors import LiveKitError
from e2e.peers.livekit.installation import check_sdk, find_client, find_server

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from e2e.lab.browsers import Window
    from e2e.lab.cell import Cell
    from e2e.lab.link import Link
    from e2e.lab.systems.running import Running
    from e2e.lab.systems.served import Served

_PLAYS_WITHIN_S: Final = 10.0
_LOOK_EVERY_S: Final = 0.1
_PLAY_THE_SOUND: Final = """(() => {
  const sound = document.getElementById("sound");
  if (!sound.hidden) sound.click();
  return sound.hidden ? document.getElementById("state").textContent : "its sound is off";
})()"""
"""Presses the button for sound if there is one, and returns what the page says of itself."""


class LiveKitRunning:
    """LiveKit, its publisher and its page, all children of one process."""

    def __init__(self, served: Served) -> None:
        self.url = f"{served.url}/"
        self.pid = served.pid
        self._served = served

    async def opened(self, window: Window) -> None:
        """Press the page's button for sound where it has one, until the page is connected."""
        until_s = time.monotonic() + _PLAYS_WITHIN_S
        while (state := await window.evaluate(_PLAY_THE_SOUND)) != "connected":
            if time.monotonic() > until_s:
                raise MeasureError(
                    f"LiveKit's page does not play, {_PLAYS_WITHIN_S:g} s on: {state}"
                )
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
    """See `e2e.lab.systems.start`."""
    how = "whip" if cell.system == "livekit-whip" else "sdk"
    check_installed(how)
    media = await film() if cell.content == "talking-head" else None
    arguments = command(how, link.server.address, media)
    async with serving("livekit", link, folder, arguments) as served:
        yield LiveKitRunning(served)


def check_installed(how: str) -> None:
    """Raise `NotRunError` when the server, the browser library or the SDK is missing."""
    try:
        find_server()
        find_client()
        if how == "sdk":
            check_sdk()
    except LiveKitError as error:
        raise NotRunError(str(error)) from error


def command(how: str, address: str, media: Path | None) -> list[str]:
    """Return Python's arguments; without a film the test card is published."""
    shown = [] if media is None else ["--media", str(media)]
    place = ["--host", address, "--port", str(PORT)]
    return ["-m", "e2e.peers.livekit", "--how", how, *place, *shown]
