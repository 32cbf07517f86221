"""However a viewer loses the controls, the robot stands half a second later."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest
import pytest_asyncio

from e2e.harness import toml
from e2e.harness.robot import moves, stands_still, turn_by_key
from e2e.harness.touch_screen import TouchPoints

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

HIDE = """() => {
    Object.defineProperty(document, "visibilityState", { value: "hidden", configurable: true });
    Object.defineProperty(document, "hidden", { value: true, configurable: true });
    document.dispatchEvent(new Event("visibilitychange"));
}"""
"""What a tab in the background tells its page; headless Chromium keeps every tab in front."""


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def server(serve: Serve, tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Server]:
    settings = toml.card_with(turns=toml.BRIEF_GRACE)
    async with serve(tmp_path_factory.mktemp("release"), settings) as running:
        yield running


@pytest_asyncio.fixture(loop_scope="session")
async def turning(server: Server, open_viewer: OpenViewer) -> Viewer:
    """Hold the left key until the robot turns."""
    viewer = await open_viewer(server)
    await viewer.join()
    await viewer.drives()
    await turn_by_key(server, viewer)
    return viewer


@pytest.mark.timeout(90)
@pytest.mark.parametrize(
    "event",
    [
        "() => window.dispatchEvent(new Event('blur'))",
        "() => window.dispatchEvent(new Event('pagehide'))",
        HIDE,
    ],
    ids=["blur", "pagehide", "hidden"],
)
async def test_a_page_out_of_hands_stops(server: Server, turning: Viewer, event: str) -> None:
    """Blur, pagehide and a hidden tab release a held key, which stays released."""
    await turning.page.evaluate(event)
    assert await stands_still(server)


@pytest.mark.timeout(90)
async def test_after_blur_a_new_press_drives_again(server: Server, turning: Viewer) -> None:
    """A release by blur does not lock the controls."""
    await turning.page.evaluate("() => window.dispatchEvent(new Event('blur'))")
    assert await stands_still(server)
    await turning.page.keyboard.up("ArrowLeft")
    await turn_by_key(server, turning)
    await turning.page.keyboard.up("ArrowLeft")
    assert await stands_still(server)


@pytest.mark.timeout(90)
async def test_going_to_another_address_stops(server: Server, turning: Viewer) -> None:
    """Leaving the page while a key is held stops the robot."""
    await turning.page.goto("about:blank")
    assert await stands_still(server)


@pytest.mark.timeout(90)
async def test_a_closed_tab_stops(server: Server, turning: Viewer) -> None:
    """Closing the tab while a key is held stops the robot."""
    await turning.page.close()
    assert await stands_still(server)


@pytest.mark.timeout(90)
async def test_a_frozen_page_stops(server: Server, turning: Viewer) -> None:
    """A page whose script hangs sends nothing, and what it sent last does not last."""
    hang = turning.page.evaluate(
        "() => { const end = Date.now() + 2500; while (Date.now() < end); }"
    )
    hanging = asyncio.create_task(hang)
    assert await stands_still(server)
    await hanging


@pytest.mark.timeout(90)
async def test_a_cancelled_touch_stops(server: Server, open_viewer: OpenViewer) -> None:
    """A touch that the system takes away releases the button under it."""
    viewer = await open_viewer(server, has_touch=True)
    await viewer.drive_by("Buttons")
    await viewer.join()
    await viewer.drives()
    points = await TouchPoints.of(viewer)
    await points.press(0, viewer.button("Left"))
    assert await moves(server)
    await points.cancel()
    assert await stands_still(server)
