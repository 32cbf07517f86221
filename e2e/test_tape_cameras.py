"""Cameras beside the driving view on the tape: recorded though nobody looks, replayed in step."""

from __future__ import annotations

import asyncio
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any, Final

import pytest

from e2e.harness import toml
from e2e.harness.mortal_camera import SOURCE, plug
from e2e.harness.replay import replayed
from e2e.harness.viewer import Viewer
from e2e.harness.wait import eventually
from wax.tape.shelf import Shelf

if TYPE_CHECKING:
    from playwright.async_api import Browser

    from e2e.conftest import Serve

RECORDING: Final = toml.card_with(recording="enabled = true\nmin_free_gb = 0.0")
CAMERAS: Final = f"""
[[camera]]
name = "Door"
source = "testcard"
codec = "h264"
[[camera]]
name = "Tail"
source = "{SOURCE}"
"""
FRAME_MS: Final = (40.0, 73.0, 73.0)
"""So long a picture stands: of the driving view, and of the cameras at 15 pictures a second."""
DEAD_AFTER_S: Final = 6.0

SEEK: Final = """async (ms) => {
  const videos = [...document.querySelectorAll("video")];
  const shown = Promise.all(videos.map((_, at) => window.waxProbe.cards(1, at)));
  videos[0].currentTime = ms / 1000;
  const at_ms = videos[0].currentTime * 1000;
  return (await shown).map(([card]) => ({ ...card, at_ms }));
}"""
PLAY: Final = """() => Promise.all(
  [30, 15, 15].map((count, at) => window.waxProbe.cards(count, at))
)"""


async def _record(serve: Serve, folder: Path) -> Path:
    """Record until a while after one camera has died; nobody watches."""
    async with serve(folder, RECORDING + CAMERAS) as server:
        shelf = Shelf(server.state_folder / "tape")

        async def films() -> bool:
            parts = shelf.parts()
            return bool(parts) and len(parts[0].cameras) == 2

        await eventually(films, "both cameras are on the tape")
        await asyncio.sleep(DEAD_AFTER_S)
        pulled = plug(server.state_folder.parent)
        pulled.touch()
        try:
            await asyncio.sleep(2.5)
        finally:
            pulled.unlink()
            tape = (await server.status())["tape"]
        assert (tape["problem"], tape["left_out"]) == (None, 0)
    return shelf.folder


@pytest.mark.full
@pytest.mark.timeout(120)
async def test_cameras_are_replayed_in_step(
    serve: Serve, tmp_path: Path, chromium: Browser, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the cards' stamps, in two codecs, standing and playing; a dead one shows nothing."""
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[1]))
    folder = await _record(serve, tmp_path)
    (part,) = Shelf(folder).parts()
    assert [part.cameras[one].suffix for one in (1, 2)] == [".mp4", ".webm"]
    context = await chromium.new_context()
    async with replayed(folder) as url:
        page = (viewer := await Viewer.prepare(context, url)).page
        await page.goto(url)
        large = page.get_by_role("button", name="Make Door large")
        await large.wait_for()

        async def is_ready() -> bool:
            states = "[...document.querySelectorAll('video')].map((one) => one.readyState)"
            return bool(min(await page.evaluate(states)) >= 2)

        await eventually(is_ready, "all pictures are there")
        content: dict[str, Any] = await page.evaluate(
            "fetch(`api/tape/${'" + part.name + "'}`).then((answer) => answer.json())"
        )
        assert content["problem"] is None
        assert [one["name"] for one in content["cameras"]] == ["Door", "Tail"]
        for ms in (2300, 4700, 3100):
            cards = await page.evaluate(SEEK, ms)
            for card, frame_ms in zip(cards, FRAME_MS, strict=True):
                assert card["valid"]
                moment_ms = (content["began_wall_ms"] + card["at_ms"]) % 2**40
                assert -5 <= moment_ms - card["stamp_ms"] <= frame_ms

        await page.get_by_role("button", name="Play").click()
        await asyncio.sleep(0.7)
        driving, *beside = await page.evaluate(PLAY)
        for cards in beside:
            apart_ms = [
                card["stamp_ms"] - min(driving, key=lambda one: _between(one, card))["stamp_ms"]
                for card in cards
            ]
            assert abs(median(apart_ms)) <= FRAME_MS[1]
        await page.get_by_role("button", name="Pause").click()

        await page.keyboard.press("c")
        await large.wait_for(state="hidden")
        await page.get_by_role("button", name="Make Driving view large").click()
        await large.wait_for()
        assert await page.get_by_text("No picture then.").count() == 0
        await page.get_by_role("slider", name="Time").press("End")
        await page.get_by_text("No picture then.").wait_for()
        assert viewer.errors == []
    await context.close()


def _between(one: dict[str, Any], other: dict[str, Any]) -> float:
    """Return how long was between the moments at which these were shown, in ms."""
    return abs(float(one["now_ms"] - other["now_ms"]))
