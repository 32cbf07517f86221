"""Stock Firefox: picture, sound, drive."""

from __future__ import annotations

import asyncio
import json
from contextlib import AsyncExitStack
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING

import pytest

from e2e.harness import audio_probe, speech, toml
from e2e.harness.bidi import firefox
from e2e.harness.installed import FIREFOX, installed, needed
from e2e.harness.microphone import hearing
from e2e.harness.robot import moves, stands_still, undisturbed
from e2e.harness.video_probe import LIVE_MS
from e2e.harness.wait import eventually
from e2e.measure.ear import open_ear

if TYPE_CHECKING:
    from e2e.conftest import Serve
    from e2e.harness.bidi import Firefox
    from e2e.measure.ear import Ear

PROBE = Path(__file__).parent / "harness" / "probe.js"
ARROW_LEFT = "\ue012"
FEEDBACK = "http://www.ietf.org/id/draft-holmer-rmcat-transport-wide-cc-extensions-01"
LARGEST = "640x480 at 1000 kbit/s"


def button(name: str) -> str:
    """Return a script that presses the button with this text or label."""
    return (
        "[...document.querySelectorAll('button')].find((b) => "
        f"(b.getAttribute('aria-label') ?? b.textContent).trim() === '{name}').click()"
    )


@pytest.mark.timeout(120)
async def test_firefox_shows_sounds_and_drives(
    serve: Serve, tmp_path: Path, ear: Ear | None
) -> None:
    """In stock Firefox the card is read live, the sound has energy, and a key moves the robot."""
    path = installed(*FIREFOX)
    profile = tmp_path / "profile"
    profile.mkdir()
    async with (
        serve(tmp_path, toml.CARD) as server,
        firefox(path, profile, PROBE.read_text(encoding="utf-8"), needed(ear)) as window,
    ):
        await window.goto(server.url)
        await eventually(
            lambda: window.evaluate("waxProbe.playing()"), "the picture plays", within_s=20
        )
        cards = await window.evaluate("waxProbe.cards(40)")
        valid = [card for card in cards if card["valid"]]
        assert len(valid) >= 36
        assert valid[-1]["stamp_ms"] - valid[0]["stamp_ms"] > 1000
        assert median(card["age_ms"] for card in valid) < LIVE_MS

        # Where the picture has it the server begins with little and goes by what it is told; the
        # sound has it too since some version after 140.
        sections = (await window.evaluate("waxProbe.answer()")).split("m=")[1:]
        agreed = {one.split()[0] for one in sections if FEEDBACK in one}
        assert "video" in agreed, "Firefox is served by what it loses"
        tap = needed(ear).tap()
        await window.evaluate(button("Turn sound on"))
        assert await tap.hears(within_s=10)

        async def is_large() -> bool:
            card = (await window.evaluate("waxProbe.cards(1)"))[0]
            (viewer,) = (await server.status())["viewers"]
            sent = viewer["streams"].get("rendition")
            return (sent, card["width"], card["height"]) == (LARGEST, 640, 480)

        await eventually(is_large, "the picture is as large as it gets", within_s=10)
        tap.take()
        await asyncio.sleep(2)
        assert audio_probe.loudness(tap.take()) > 0.02

        await window.evaluate(button("Join the queue"))

        await reads(window, "You are driving")

        async def moves_by_key() -> bool:
            await window.key("keyDown", ARROW_LEFT)
            moved = await moves(server, during_s=0.8)
            await window.key("keyUp", ARROW_LEFT)
            assert await stands_still(server)
            return moved

        assert await undisturbed(server, moves_by_key)


SPOKEN_S = 12.0
HEARD_S = 4
"""Of the first half second nothing is asked, in which the browser finds its level."""


@pytest.mark.timeout(120)
@pytest.mark.full
async def test_firefox_speaks_to_the_robot(serve: Serve, tmp_path: Path) -> None:
    """The words that Firefox's microphone hears are those of the robot's speaker."""
    path = installed(*FIREFOX)
    profile = tmp_path / "profile"
    profile.mkdir()
    words, played = speech.voice(SPOKEN_S), tmp_path / "said.wav"
    async with AsyncExitStack() as leaving:
        own_ear = await leaving.enter_async_context(open_ear())
        await leaving.enter_async_context(hearing(own_ear, words))
        settings = toml.card_with(voice=f'speaker = "{played}"')
        server = await leaving.enter_async_context(serve(tmp_path, settings))
        script = PROBE.read_text(encoding="utf-8")
        window = await leaving.enter_async_context(firefox(path, profile, script, own_ear))
        await window.goto(server.url)
        await eventually(
            lambda: window.evaluate("waxProbe.playing()"), "the picture plays", within_s=20
        )
        await window.evaluate(button("Join the queue"))
        await reads(window, "You are driving")
        await window.key("keyDown", "t")
        await reads(window, "You are heard.")

        async def enough() -> bool:
            return len(speech.read(played)) > (HEARD_S + 0.5) * speech.RATE_HZ

        await eventually(enough, "the speaker plays", within_s=20)
        await window.key("keyUp", "t")
        heard = speech.read(played)[speech.RATE_HZ // 2 :]
        assert speech.in_order(heard, words) >= 0.5


async def reads(window: Firefox, sentence: str) -> None:
    """Wait until the page says this."""
    says = f"document.body.innerText.includes({json.dumps(sentence)})"
    await eventually(lambda: window.evaluate(says), f"the page says “{sentence}”")
