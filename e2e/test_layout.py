"""Nothing that a person opens hides what a driver must see."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
import pytest_asyncio

from e2e.harness import toml
from wax.client import Operator

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from playwright.async_api import FloatRect, Locator

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server

LAYOUTS = ((1280, 800), (900, 560), (390, 844), (844, 390))
"""A large window, the smallest that counts as one, and a phone held upright and across."""
PANELS = ("People", "Settings", "Details", "Safety")


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def server(serve: Serve, tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Server]:
    settings = toml.card_with(turns=toml.BRIEF_GRACE)
    async with serve(tmp_path_factory.mktemp("layout"), settings) as running:
        yield running


async def _box(locator: Locator) -> FloatRect:
    box = await locator.bounding_box()
    assert box is not None, f"{locator} is not shown"
    return box


def _overlap(one: FloatRect, other: FloatRect) -> bool:
    return (
        one["x"] < other["x"] + other["width"]
        and other["x"] < one["x"] + one["width"]
        and one["y"] < other["y"] + other["height"]
        and other["y"] < one["y"] + one["height"]
    )


@pytest.mark.timeout(60)
async def test_no_panel_hides_the_turn_or_a_drive_button(
    server: Server, open_viewer: OpenViewer
) -> None:
    """A panel opens beside or below the turn and the drive buttons, or over the picture alone."""
    viewer = await open_viewer(server)
    await viewer.join()
    await viewer.drives()
    page = viewer.page
    for width, height in LAYOUTS:
        await page.set_viewport_size({"width": width, "height": height})
        for panel in PANELS:
            await viewer.open(panel)
            opened = await _box(page.get_by_role("region", name=panel, exact=True))
            assert not _overlap(opened, await _box(page.get_by_role("region", name="Turn")))
            for name in ("Forward", "Back", "Left", "Right", "Stop"):
                where = (width, height, panel, name)
                assert not _overlap(opened, await _box(viewer.button(name))), where


@pytest.mark.timeout(60)
async def test_the_picture_fills_its_own_box(server: Server, open_viewer: OpenViewer) -> None:
    """Nothing black lies beside the picture: its box has its shape, and lies in the window."""
    viewer = await open_viewer(server)
    await viewer.sees_picture()
    for width, height in LAYOUTS:
        await viewer.page.set_viewport_size({"width": width, "height": height})
        box = await _box(viewer.page.get_by_role("region", name="Picture", exact=True))
        assert box["width"] / box["height"] == pytest.approx(640 / 480, rel=0.02), (width, height)
        assert box["x"] >= 0
        assert box["y"] >= 0
        assert box["x"] + box["width"] <= width
        assert box["y"] + box["height"] <= height


@pytest.mark.timeout(60)
@pytest.mark.parametrize("size", LAYOUTS)
async def test_stop_is_in_sight_whatever_is_open(
    server: Server, open_viewer: OpenViewer, size: tuple[int, int]
) -> None:
    """Who watches never has to scroll to Stop, whichever panel they have opened."""
    viewer = await open_viewer(server)
    width, height = size
    await viewer.page.set_viewport_size({"width": width, "height": height})
    for panel in PANELS:
        await viewer.open(panel)
        box = await _box(viewer.button("Stop"))
        assert box["y"] >= 0
        assert box["y"] + box["height"] <= height, panel


@pytest.mark.timeout(60)
async def test_who_waits_can_read_what_lies_over_the_picture(
    server: Server, open_viewer: OpenViewer
) -> None:
    """On a phone held across, the hint over the picture is as light as the buttons there."""
    viewer = await open_viewer(server)
    await viewer.page.set_viewport_size({"width": 844, "height": 390})
    async with Operator(server.url, name="Ada") as operator:
        await operator.join()
        await viewer.join()
        hint = viewer.page.get_by_text("You drive when it is your turn.", exact=True)
        await hint.wait_for()
        colour = "one => getComputedStyle(one).color"
        button = await viewer.button("Safety").evaluate(colour)
        assert await hint.evaluate(colour) == button
        await viewer.leave()
