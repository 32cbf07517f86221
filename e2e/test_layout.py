"""Nothing that a person opens hides what a driver must see."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import pytest
import pytest_asyncio

from e2e.harness import toml

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from playwright.async_api import FloatRect, Locator

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server

LAYOUTS = ((1280, 800), (900, 560), (390, 844), (844, 390))
"""A large window, the smallest that counts as one, and a phone held upright and across."""


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
async def test_the_delay_in_full_hides_no_turn_and_no_button(
    server: Server, open_viewer: OpenViewer
) -> None:
    """The delay's details open over the picture, never over the turn or a drive button."""
    viewer = await open_viewer(server)
    await viewer.join()
    await viewer.drives()
    page = viewer.page
    await page.get_by_text(re.compile("^Delay")).click()
    details = page.get_by_role("definition").first.locator("..")
    for width, height in LAYOUTS:
        await page.set_viewport_size({"width": width, "height": height})
        opened = await _box(details)
        assert _overlap(opened, await _box(page.get_by_role("region", name="Picture", exact=True)))
        assert not _overlap(opened, await _box(page.get_by_role("region", name="Turn")))
        for name in ("Forward", "Back", "Left", "Right", "Stop"):
            assert not _overlap(opened, await _box(viewer.button(name))), (width, height, name)
