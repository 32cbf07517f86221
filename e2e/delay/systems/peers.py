"""How LiveKit differs from a server that only answers HTTP (see `e2e.peers`)."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING, Final

from e2e.delay.systems.served import Served
from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from playwright.async_api import Page

_PLAYS_WITHIN_S: Final = 10.0
_LOOK_EVERY_S: Final = 0.1
_PLAY_THE_SOUND: Final = """(() => {
  const sound = document.getElementById("sound");
  if (!sound.hidden) sound.click();
  return sound.hidden ? document.getElementById("state").textContent : "its sound is off";
})()"""
"""Presses the button for sound if there is one, and returns what the page says of its state."""


class LiveKit(Served):
    """LiveKit, a child of the process that publishes and serves the page."""

    async def opened(self, window: Page) -> None:
        """Press the page's button for sound if it has one, until the page is connected."""
        until_s = time.monotonic() + _PLAYS_WITHIN_S
        while (state := await window.evaluate(_PLAY_THE_SOUND)) != "connected":
            if time.monotonic() > until_s:
                raise MeasureError(f"LiveKit's page does not play in time: {state}")
            await asyncio.sleep(_LOOK_EVERY_S)
