"""The tape from end to end: recorded while somebody drives, and replayed in a browser."""

from __future__ import annotations

import asyncio
import math
import re
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

import av
import pytest

from e2e.harness import toml
from e2e.harness.commands import replayed
from e2e.harness.robot import turn_by_key
from e2e.harness.viewer import Viewer
from e2e.harness.wait import eventually
from wax.tape.shelf import Shelf

if TYPE_CHECKING:
    from pathlib import Path

    from playwright.async_api import Browser

    from e2e.conftest import OpenViewer, Serve

FRAME_MS: Final = 40.0
"""How long a picture lasts where none is left out."""
ROUNDED_MS: Final = 2.0
"""A picture's stamp and its time in WebM are whole milliseconds."""
RECORDING: Final = toml.card_with(
    recording="""
enabled = true
min_free_gb = 0.0
names = true
purpose = "A robot learns from it."
ask_task = true
"""
)


def times_ms(media: Path) -> list[float]:
    """Return when the pictures of a part are due: a busy machine leaves some out."""
    with av.open(str(media)) as file:
        stream = file.streams.video[0]
        return [
            float(one.pts * one.time_base * 1000)
            for one in file.demux(stream)
            if one.pts is not None and one.time_base is not None
        ]


async def reads_it_on_each_screen(viewer: Viewer) -> None:
    """Check that the badge hides no word, and that its sentence is complete."""
    as_it_was = viewer.page.viewport_size
    for width, height in ((360, 740), (844, 390), (1280, 800)):
        await viewer.resize(width, height)
        link, badge, why = await viewer.probe('places(".link", ".tape summary", ".tape-why")')
        assert link["right"] <= badge["left"]
        assert why["left"] >= 0
        assert why["right"] <= width
        assert why["bottom"] <= height
    if as_it_was is not None:
        await viewer.page.set_viewport_size(as_it_was)


@pytest.mark.full
@pytest.mark.timeout(120)
async def test_what_was_driven_is_replayed(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer, chromium: Browser
) -> None:
    """Everybody sees that it runs; later the page shows picture, stop and name at their times."""
    async with serve(tmp_path, RECORDING) as server:
        ada = await open_viewer(server)
        await ada.call_oneself("Ada")
        badge = ada.page.locator("details.tape")
        await badge.get_by_text("Recorded", exact=True).click()
        await badge.get_by_text("Picture, sound and driving are recorded, with names").wait_for()
        assert await badge.get_by_role("button").count() == 0  # she is not in charge yet
        await reads_it_on_each_screen(ada)
        await ada.takes_the_wheel()
        await badge.get_by_role("button", name="Keep the last two minutes").click()
        await ada.page.get_by_text("The last two minutes are kept.").wait_for()
        task = ada.page.get_by_role("textbox", name="Your task")
        await task.fill("a little ahead")
        await task.press("Enter")  # which returns the keys to driving
        await turn_by_key(server, ada, "ArrowUp")
        await asyncio.sleep(1.0)
        await ada.button("Stop").click()
        await ada.page.keyboard.up("ArrowUp")
        await asyncio.sleep(0.5)
        await ada.button("End my turn").click()
        await ada.button("Do not use my recording").click()
        await ada.page.get_by_text("The recording of your turn will not be used.").wait_for()
        folder = server.state_folder / "tape"
    (part,) = Shelf(folder).parts()
    assert part.kept == "operator"
    ((driven_s, ended_s),) = part.disowned
    assert part.began_s <= driven_s < ended_s - 1.5
    assert part.media is not None
    pictures_ms = times_ms(part.media)

    async with await chromium.new_context() as context, replayed(folder) as url:
        page = (viewer := await Viewer.prepare(context, url)).page

        async def video(what: str) -> Any:
            return await page.evaluate(f"document.querySelector('video').{what}")

        await page.goto(url)
        await page.get_by_role("button", name="Play").wait_for()
        await eventually(lambda: video("readyState >= 2"), "the picture is there")
        content: dict[str, Any] = await page.evaluate(
            "fetch(`api/tape/${'" + part.name + "'}`).then((answer) => answer.json())"
        )
        assert content["problem"] is None
        began_ms = content["began_wall_ms"]
        events = {one["event"]["type"]: one["event"] for one in content["events"]}
        assert events["tasked"]["text"] == "a little ahead"
        assert events["tasked"]["turn"] == events["turned"]["number"]

        async def shows(at_ms: float) -> bool:
            card = await viewer.probe("newest()")
            # The newest, or one before: a browser takes each to last as long as earlier ones did.
            earlier_ms = [one for one in pictures_ms if one <= at_ms]
            lasts_ms = max(after - before for before, after in pairwise(earlier_ms))
            first_ms = min(earlier_ms[-1], at_ms - lasts_ms) - ROUNDED_MS
            stamped_ms = (card["stamp_ms"] - began_ms) % 2**40 if card else math.inf
            return first_ms <= stamped_ms <= at_ms + ROUNDED_MS

        await viewer.probe("keepNewest()")
        for ms in (400, 2100, 1300):
            await page.evaluate(f"document.querySelector('video').currentTime = {ms / 1000}")
            await eventually(partial(shows, ms), "the picture of that moment is shown")

        await page.get_by_role("button", name=re.compile("Stop pressed by Ada")).click()
        await page.get_by_text("Stopped by Ada").wait_for()
        stop_ms = next(
            one["at_ms"] for one in content["events"] if one["event"]["type"] == "stopped"
        )
        shown_ms = await video("currentTime * 1000")
        assert abs(shown_ms - stop_ms) <= FRAME_MS
        await page.get_by_role("combobox", name="Show it").select_option("seen")
        earlier_ms = await video("currentTime * 1000")
        assert earlier_ms < shown_ms  # she saw it later than it was

        await page.get_by_role("combobox", name="Speed").select_option("0.5")
        assert await video("playbackRate") == 0.5
        await page.get_by_role("button", name="Play").click()
        await eventually(lambda: video("paused === false"), "it plays")
        assert viewer.errors == []
