"""A modem line between server and browser: thin, and not broken."""

from __future__ import annotations

import asyncio
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from e2e.browsers import open_browser
from e2e.delay.cell import Cell
from e2e.delay.systems import origin, start
from e2e.harness.missing import missing
from e2e.harness.wait import eventually
from e2e.link import Link, UnavailableError
from e2e.measure.errors import NotRunError

if TYPE_CHECKING:
    from e2e.browsers import Window
    from e2e.delay.systems import Running

PROBE = Path(__file__).parent / "harness" / "probe.js"
CELL = Cell(experiment="E4", profile="modem-56k", system="audio-master")
WITHIN_S = 20.0
"""From the page's address to picture and sound; half of it is what the page itself takes."""

SMALLEST = "160x120 at 16 kbit/s"
LONGEST_MS = 60.0
PROBLEMS = """
[...document.querySelectorAll('[aria-label="Problems"] li')].map((line) => line.innerText)
"""
STATUS = "document.querySelector('[role=\"status\"]').innerText"


@pytest.mark.timeout(120)
@pytest.mark.full
async def test_a_modem_line_carries_picture_and_sound(tmp_path: Path) -> None:
    """On 50 kbit/s both play within 20 s, as small as they get, and nothing is said as broken."""
    rooms = [tmp_path / "server", tmp_path / "browser"]
    for room in rooms:
        room.mkdir()
    try:
        async with (
            Link(CELL.profile) as link,
            start(CELL, link, rooms[0]) as running,
            open_browser(CELL.browser, link, [origin(link)], rooms[1]) as browser,
            browser.window(PROBE.read_text(encoding="utf-8")) as window,
        ):
            await watch(running, window)
    except (UnavailableError, NotRunError) as error:
        missing(str(error))


async def watch(running: Running, window: Window) -> None:
    opened_s = time.monotonic()

    async def ask(expression: str) -> Any:
        return await window.evaluate(f"waxProbe.{expression}")

    def left_s() -> float:
        return max(opened_s + WITHIN_S - time.monotonic(), 0.0)

    await window.goto(running.url)
    await eventually(lambda: ask("playing()"), "the picture plays", within_s=left_s())
    await running.opened(window)

    async def hears() -> bool:
        sound = await ask("inbound('audio')") or {}
        return float(sound.get("totalAudioEnergy", 0)) > 0

    await eventually(hears, "the sound is no silence", within_s=left_s())

    async def fits() -> bool:
        told = await running.told()
        return (
            told.get("viewer.streams.rendition") == SMALLEST
            and told.get("viewer.streams.sound_mu_ms") == LONGEST_MS
        )

    await eventually(fits, "as little as possible is sent", within_s=left_s())
    said: set[str] = set()
    for _ in range(4):
        said |= set(await window.evaluate(PROBLEMS))
        await asyncio.sleep(0.5)
    assert not said, f"the page says that something is wrong: {said}"
    assert (await window.evaluate(STATUS)).strip() == "Connected"
    cards = await ask("cards(10)")
    assert sum(card["valid"] for card in cards) >= 9
    assert {(card["width"], card["height"]) for card in cards} == {(160, 120)}
    assert len({card["stamp_ms"] for card in cards}) >= 9, "the picture stands still"
