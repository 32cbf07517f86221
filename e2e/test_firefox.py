"""Stock Firefox: picture, sound, voice and every way to drive."""

from __future__ import annotations

import asyncio
from contextlib import AsyncExitStack
from functools import partial
from statistics import median
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import pytest

from e2e.harness import probe, speech, toml
from e2e.harness.firefox import opened, presses
from e2e.harness.gamepad import START, InjectedGamepad
from e2e.harness.installed import needed
from e2e.harness.microphone import hearing
from e2e.harness.probe import LIVE_MS
from e2e.harness.robot import holding_moves, moves
from e2e.harness.scripts import reads
from e2e.harness.speech import SPOKEN_S, are_words
from e2e.harness.wait import eventually
from e2e.measure.ear import open_ear

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.conftest import Serve
    from e2e.measure.ear import Ear

ARROW_LEFT = "\ue012"
FEEDBACK = "http://www.ietf.org/id/draft-holmer-rmcat-transport-wide-cc-extensions-01"
LARGEST = "640x480 at 1000 kbit/s"

pytestmark = pytest.mark.timeout(120)


async def test_firefox_shows_sounds_and_drives(
    serve: Serve, tmp_path: Path, ear: Ear | None
) -> None:
    """In stock Firefox the card is read live, our player's sound has energy, and a key drives."""
    async with (
        serve(tmp_path, toml.CARD) as server,
        opened(server, tmp_path, needed(ear)) as window,
    ):

        async def is_live() -> bool:
            cards = await window.evaluate("waxProbe.cards(40)")
            valid = [card for card in cards if card["valid"]]
            assert len(valid) >= 36
            assert valid[-1]["stamp_ms"] - valid[0]["stamp_ms"] > 1000
            return median(float(card["age_ms"]) for card in valid) < LIVE_MS

        # After a start on a busy machine Firefox holds pictures back for some seconds.
        await eventually(is_live, "the picture is live")

        # With transport-wide feedback for pictures, the server starts slowly and follows the
        # feedback; for sound Firefox has it since some version after 140.
        sections = (await window.evaluate("waxProbe.answer()")).split("m=")[1:]
        agreed = {one.split()[0] for one in sections if FEEDBACK in one}
        assert "video" in agreed, "Firefox is served by what it loses"
        tap = needed(ear).tap()
        await presses(window, "Turn sound on")
        assert await tap.hears(within_s=20)

        async def is_large() -> bool:
            card = (await window.evaluate("waxProbe.cards(1)"))[0]
            (viewer,) = (await server.status())["viewers"]
            sent = viewer["streams"].get("rendition")
            return (sent, card["width"], card["height"]) == (LARGEST, 640, 480)

        await eventually(is_large, "the picture is as large as it gets", within_s=30)

        async def is_loud() -> bool:
            tap.take()
            await asyncio.sleep(0.5)
            return probe.loudness(tap.take()) > 0.02

        await eventually(is_loud, "the sound has energy")
        await presses(window, "Details")
        ours = 'document.body.textContent.includes("Sound playerWAX\'s own")'
        await eventually(lambda: window.evaluate(ours), "it is the built-in player's", within_s=20)

        await presses(window, "Join the queue")
        await reads(window, "You are driving")
        down, up = (partial(window.key, what, ARROW_LEFT) for what in ("keyDown", "keyUp"))
        assert await holding_moves(server, down, up)


@pytest.mark.full
async def test_firefox_speaks_to_the_robot(serve: Serve, tmp_path: Path) -> None:
    """The robot's speaker plays the words that Firefox's microphone hears."""
    played, words = tmp_path / "said.wav", tmp_path / "words.wav"
    speech.write(words, np.tile(speech.voice(SPOKEN_S), 20))  # longer than the test's timeout
    async with AsyncExitStack() as leaving:
        own_ear = await leaving.enter_async_context(open_ear())
        await leaving.enter_async_context(hearing(own_ear, words))
        settings = toml.card_with(voice=f'speaker = "{played}"')
        server = await leaving.enter_async_context(serve(tmp_path, settings))
        window = await leaving.enter_async_context(opened(server, tmp_path, own_ear))
        await presses(window, "Join the queue")
        await reads(window, "You are driving")
        await window.key("keyDown", "t")
        await reads(window, "You are heard.")
        await are_words(lambda: speech.read(played))


# --- the ways to drive other than keys ---

TOUCH_SCREEN: Final = {"ui.primaryPointerCapabilities": 1, "ui.allPointerCapabilities": 1}
"""A device that has only a touch screen."""
IN_FRONT: Final = "document.hasFocus = () => true"
"""A headless Firefox never has the focus, whatever is done to its window."""


def _at(x: float, y: float) -> dict[str, Any]:
    return {"type": "pointerMove", "x": round(x), "y": round(y)}


DOWN: Final = {"type": "pointerDown", "button": 0}
UP: Final = {"type": "pointerUp", "button": 0}


@pytest.mark.full
async def test_firefox_drives_by_joystick_and_gamepad(serve: Serve, tmp_path: Path) -> None:
    """A finger's push moves the robot; a gamepad does once its Start has chosen it."""
    async with (
        serve(tmp_path, toml.CARD) as server,
        opened(server, tmp_path, preferences=TOUCH_SCREEN) as window,
    ):
        await presses(window, "Join the queue")
        await reads(window, "You are driving")

        async def touch() -> None:
            box = await window.evaluate("waxProbe.middle('[aria-label=Joystick]')")
            up = _at(box["x"], box["y"] - 0.8 * box["half"])
            await window.touch(_at(box["x"], box["y"]), DOWN, up)

        assert await holding_moves(server, touch, partial(window.touch, UP))
        await window.evaluate(IN_FRONT)
        pad = await InjectedGamepad.plugged_in(window)
        await pad.push(1, -1)
        assert not await moves(server, within_s=0.5)
        await pad.push(1, 0)
        await pad.tap(START)
        assert await holding_moves(server, partial(pad.push, 1, -1), partial(pad.push, 1, 0))
