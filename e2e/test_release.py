"""However a viewer loses the controls, the robot stands half a second later."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final

import pytest

from e2e.harness.robot import moves, stands_still, turn_by_key
from e2e.harness.touch_screen import TouchPoints

if TYPE_CHECKING:
    from e2e.conftest import OpenViewer
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

_SHOWN: Final = """() => {
    Object.defineProperty(document, "visibilityState", { value: "STATE", configurable: true });
    Object.defineProperty(document, "hidden", { value: "STATE" === "hidden", configurable: true });
    document.dispatchEvent(new Event("visibilitychange"));
}"""
HIDE: Final = _SHOWN.replace("STATE", "hidden")
"""What a tab in the background tells its page; headless Chromium keeps every tab in front."""
SHOW: Final = _SHOWN.replace("STATE", "visible")
LOSSES: Final = {"blur": "() => window.dispatchEvent(new Event('blur'))", "hidden": HIDE}
ENDS: Final = {
    "pagehide": "() => window.dispatchEvent(new Event('pagehide'))",
    "a script that hangs": "() => { const end = Date.now() + 2500; while (Date.now() < end); }",
}
"""After these the page has lost its turn."""


@pytest.mark.timeout(90)
async def test_a_page_out_of_hands_stops(server: Server, driver: Viewer) -> None:
    """Blurred or hidden it releases a held key, and a new press drives again."""
    for name, loss in LOSSES.items():
        await turn_by_key(server, driver)
        await driver.page.evaluate(loss)
        assert await stands_still(server), name
        await driver.page.evaluate(SHOW)
        await driver.page.keyboard.up("ArrowLeft")


@pytest.mark.timeout(90)
@pytest.mark.parametrize("leave", ["another address", "a closed tab", *ENDS])
async def test_who_leaves_the_page_stops(server: Server, driver: Viewer, leave: str) -> None:
    """A link, a closed tab, a page put away or one that hangs while a key is held: it stands."""
    await turn_by_key(server, driver)
    if leave == "a closed tab":
        await driver.page.close()
    elif leave == "another address":
        await driver.page.goto("about:blank")
    else:
        leaving = asyncio.create_task(driver.page.evaluate(ENDS[leave]))
        assert await stands_still(server)
        await leaving
    assert await stands_still(server)


@pytest.mark.timeout(90)
async def test_a_cancelled_touch_stops(server: Server, open_viewer: OpenViewer) -> None:
    """A touch that the system takes away releases the button under it."""
    viewer = await open_viewer(server, has_touch=True)
    await viewer.drive_by("Buttons")
    await viewer.takes_the_wheel()
    points = await TouchPoints.of(viewer)
    await points.press(0, viewer.button("Left"))
    assert await moves(server)
    await points.cancel()
    assert await stands_still(server)
