"""Records a turn as a short loop: somebody drives the simulated robot through its flat."""

from __future__ import annotations

import asyncio
import base64
from contextlib import suppress
from itertools import count
from typing import TYPE_CHECKING, Any, Final

import cv2
import numpy as np
from playwright.async_api import Error

from e2e.gallery.scene import scene
from e2e.gallery.views import Device, Size

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from playwright.async_api import Browser

    from e2e.harness.viewer import Viewer

_SIZE: Final = Size("wide", "window, wide", 1100, 540)
_WINDOW: Final = Device("window", (_SIZE,), {"color_scheme": "dark"})
_SETTLED_S: Final = 5.0
"""The first pictures are small ones."""
_WIDTH_PX: Final = 800
_FPS: Final = 10
_QUALITY: Final = 60
_ROUTE: Final[tuple[tuple[Sequence[str], float], ...]] = (
    (("ArrowRight",), 0.45),
    (("ArrowUp",), 3.0),
    (("ArrowUp", "ArrowLeft"), 0.5),
    (("ArrowUp",), 2.0),
    (("ArrowUp", "ArrowRight"), 0.4),
    (("ArrowUp",), 3.5),
    ((), 2.0),
)
"""Which keys are held, and for how many seconds: past the pillar, into the kitchen."""


async def record(browser: Browser, path: Path) -> None:
    """Write what the page showed, as an animated picture."""
    async with scene(browser, _WINDOW) as made:
        viewer = await made.opens()
        await asyncio.sleep(_SETTLED_S)
        screen = await _Screen.of(viewer)
        await asyncio.sleep(1)
        await viewer.takes_the_wheel()
        await viewer.speed("Fast").click()
        keyboard = viewer.page.keyboard
        for keys, seconds in _ROUTE:
            for key in keys:
                await keyboard.down(key)
            await asyncio.sleep(seconds)
            for key in keys:
                await keyboard.up(key)
        pictures = screen.pictures()
    loop = cv2.Animation()
    loop.frames = pictures
    loop.durations = [1000 // _FPS] * len(pictures)
    cv2.imwriteanimation(str(path), loop, [cv2.IMWRITE_WEBP_QUALITY, _QUALITY])


class _Screen:
    """What a page has shown since, each picture with its time in seconds."""

    def __init__(self) -> None:
        self._seen: list[tuple[float, bytes]] = []

    @classmethod
    async def of(cls, viewer: Viewer) -> _Screen:
        screen = cls()
        devtools = await viewer.page.context.new_cdp_session(viewer.page)

        async def saw(frame: dict[str, Any]) -> None:
            picture = base64.b64decode(frame["data"])
            screen._seen.append((frame["metadata"]["timestamp"], picture))
            with suppress(Error):  # its page is closed by then
                await devtools.send("Page.screencastFrameAck", {"sessionId": frame["sessionId"]})

        devtools.on("Page.screencastFrame", saw)
        how = {"format": "jpeg", "quality": 90, "everyNthFrame": 3}
        await devtools.send("Page.startScreencast", how)
        return screen

    def pictures(self) -> list[Any]:
        """Return what stood on the page at each time of the loop."""
        first_s, last_s = self._seen[0][0], self._seen[-1][0]
        found: list[Any] = []
        number = 0
        for due_s in (first_s + n / _FPS for n in count()):
            if due_s > last_s:
                return found
            while number + 1 < len(self._seen) and self._seen[number + 1][0] <= due_s:
                number += 1
            data = np.frombuffer(self._seen[number][1], np.uint8)
            picture: Any = cv2.imdecode(data, cv2.IMREAD_COLOR)
            height, width = picture.shape[:2]
            size = _WIDTH_PX, round(height * _WIDTH_PX / width)
            found.append(cv2.resize(picture, size, interpolation=cv2.INTER_AREA))
        raise AssertionError
