"""What makes watching pleasant: photos, a picture apart, fullscreen, timing, volume."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import cv2
import numpy as np
import pytest
import pytest_asyncio
from playwright.async_api import expect

from e2e.harness import toml
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

SILENT = 0.02
"""Of the loudness at full volume."""


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def server(serve: Serve, tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Server]:
    settings = toml.card_with(turns=toml.BRIEF_GRACE)
    async with serve(tmp_path_factory.mktemp("watching"), settings) as running:
        yield running


@pytest.mark.timeout(60)
async def test_a_photo_is_what_is_seen(
    server: Server, open_viewer: OpenViewer, tmp_path: Path
) -> None:
    """A photo is the picture in its own size; without a picture there is none, but a reason."""
    viewer = await open_viewer(server)
    # It begins small and grows, and photo and picture are to be of one size.
    is_grown = "document.querySelector('video').videoWidth === 640"
    await eventually(lambda: viewer.page.evaluate(is_grown), "the picture is as large as it gets")
    await viewer.open("Settings")
    async with viewer.page.expect_download() as saving:
        await viewer.button("Take a photo").click()
    photo = await saving.value
    assert photo.suggested_filename.endswith(".png")
    await photo.save_as(tmp_path / "photo.png")
    taken = cv2.imread(str(tmp_path / "photo.png"))
    assert taken is not None, "the photo is no picture"
    [card] = await viewer.cards(1)
    assert taken.shape[:2] == (card.height, card.width)
    assert np.std(taken) > 10, "the photo is of one colour"
    await viewer.switch("Picture").click()
    await viewer.button("Take a photo").click()
    await expect(viewer.page.get_by_text("switch it on to take a photo")).to_be_visible()


@pytest.mark.timeout(60)
async def test_fullscreen_begins_and_ends(server: Server, open_viewer: OpenViewer) -> None:
    """The whole page goes to fullscreen and comes back, by the same button."""
    viewer = await open_viewer(server)
    await viewer.open("Settings")
    await viewer.button("Fullscreen").click()
    leave = viewer.button("Leave fullscreen")
    await expect(leave).to_be_visible()
    assert await viewer.page.evaluate("document.fullscreenElement === document.documentElement")
    await leave.click()
    await expect(viewer.button("Fullscreen")).to_be_visible()


@pytest.mark.timeout(60)
async def test_smooth_or_immediate(server: Server, open_viewer: OpenViewer) -> None:
    """Who chooses “Immediate” is served the picture first."""
    viewer = await open_viewer(server)
    await viewer.open("Settings")
    await viewer.choose_timing("Immediate")
    await viewer.open("Details")
    details = viewer.page.get_by_role("region", name="Details", exact=True)
    await expect(details.get_by_text("Immediate", exact=True)).to_be_visible()


async def loudness(viewer: Viewer) -> float:
    """Return how loud the browser is over half a second."""
    viewer.forget()
    await asyncio.sleep(0.5)
    return float(np.std(viewer.sound().astype(np.float64)))


@pytest.mark.timeout(90)
@pytest.mark.parametrize("player", ["built-in", pytest.param("browser", marks=pytest.mark.full)])
async def test_volume_and_mute_are_heard(
    server: Server, open_viewer: OpenViewer, player: str
) -> None:
    """Softer is softer and muted is silent, by either player, and heard again at once."""
    viewer = await open_viewer(server)
    await viewer.listen()
    await viewer.open("Details")
    await viewer.page.get_by_role("combobox", name="Play sound by").select_option(player)
    await viewer.open("Settings")
    await asyncio.sleep(3)
    full = max([await loudness(viewer) for _ in range(4)])
    await viewer.page.get_by_role("slider", name="Volume").fill("50")
    await asyncio.sleep(0.5)
    half = max([await loudness(viewer) for _ in range(4)])
    assert 0.15 * full < half < 0.4 * full
    await viewer.button("Mute").click()

    async def is_silent() -> bool:
        return await loudness(viewer) < SILENT * full

    await eventually(is_silent, "nothing is heard", within_s=5)
    await viewer.button("Unmute").click()

    async def is_heard() -> bool:
        return await loudness(viewer) > 0.15 * full

    await eventually(is_heard, "it is heard again", within_s=5)
