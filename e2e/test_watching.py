"""What makes watching pleasant: photos, fullscreen, volume."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import cv2
import numpy as np
import pytest
from playwright.async_api import expect

from e2e.harness.installed import needed
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.conftest import OpenViewer
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer
    from e2e.measure.ear import Ear

SILENT = 0.02
"""A fraction of the loudness at full volume."""


async def test_a_photo_is_what_is_seen(
    server: Server, open_viewer: OpenViewer, tmp_path: Path
) -> None:
    """A photo is the picture in its own size, and none exists without one; fullscreen works."""
    viewer = await open_viewer(server)
    # The picture starts small and grows, and the photo must have the same size.
    is_grown = "document.querySelector('video').videoWidth === 640"
    await eventually(
        lambda: viewer.page.evaluate(is_grown), "the picture is as large as it gets", within_s=30
    )
    await viewer.open("Settings")
    await viewer.button("Fullscreen").click()
    leave = viewer.button("Leave fullscreen")
    await expect(leave).to_be_visible()
    assert await viewer.page.evaluate("document.fullscreenElement === document.documentElement")
    await leave.click()
    await expect(viewer.button("Fullscreen")).to_be_visible()
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


async def loudness(viewer: Viewer) -> float:
    """Return how loud the browser is over half a second."""
    viewer.forget()
    await asyncio.sleep(0.5)
    return float(np.std(viewer.sound().astype(np.float64)))


@pytest.mark.full
@pytest.mark.timeout(90)
async def test_volume_and_mute_are_heard(
    server: Server, open_viewer: OpenViewer, ear: Ear | None
) -> None:
    """It is silent until Start; then softer is softer, muted is silent, and it comes back at once.

    Switched off, no sound is sent or encoded, while the picture continues.
    """
    viewer = await open_viewer(server)
    tap = needed(ear).tap()
    assert not await tap.hears(within_s=1.5)
    await viewer.listen()
    await viewer.open("Settings")
    await asyncio.sleep(3)
    full = max([await loudness(viewer) for _ in range(4)])
    await viewer.page.get_by_role("slider", name="Volume").fill("50")

    async def is_half_as_loud() -> bool:
        return 0.15 * full < max([await loudness(viewer) for _ in range(3)]) < 0.4 * full

    await eventually(is_half_as_loud, "softer is softer", within_s=20)
    await viewer.button("Mute").click()

    async def is_silent() -> bool:
        return await loudness(viewer) < SILENT * full

    await eventually(is_silent, "nothing is heard", within_s=20)
    await viewer.button("Unmute").click()

    async def is_heard() -> bool:
        return await loudness(viewer) > 0.15 * full

    await eventually(is_heard, "it is heard again", within_s=20)

    await viewer.switch("Sound").click()

    async def rests() -> bool:
        before = await viewer.packets("audio")
        await asyncio.sleep(0.7)
        streams = (await server.status())["streams"]
        return await viewer.packets("audio") == before and not streams["audio"]["encoded_hz"]

    await eventually(rests, "no sound is sent nor encoded that nobody wants", within_s=20)
    await viewer.receives_more("video")
    await viewer.switch("Sound").click()
    await eventually(is_heard, "switched on it is heard again", within_s=20)
