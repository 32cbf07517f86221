"""Stock Firefox where the robot has no place for it: picture and sound come from a room."""

from __future__ import annotations

from statistics import median
from typing import TYPE_CHECKING

import pytest

from e2e.harness import audio_probe
from e2e.harness.bidi import firefox
from e2e.harness.missing import needed
from e2e.harness.video_probe import LIVE_MS
from e2e.harness.wait import eventually
from e2e.load.cluster.stage import published
from e2e.test_firefox import PROBE, button, find_firefox
from wax.client.operator import Operator

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.conftest import Serve
    from e2e.measure.ear import Ear

WATCHING = r"(person watches|people watch)\."


@pytest.mark.timeout(150)
async def test_firefox_watches_in_a_room(serve: Serve, tmp_path: Path, ear: Ear | None) -> None:
    """The card is read live, the sound is heard, and no place at the robot is taken."""
    path = find_firefox()
    profile = tmp_path / "profile"
    profile.mkdir()
    async with (
        published(serve, tmp_path) as (_, server),
        Operator(server.url),
        firefox(path, profile, PROBE.read_text(encoding="utf-8"), needed(ear)) as window,
    ):
        await window.goto(server.url)
        await eventually(
            lambda: window.evaluate("waxProbe.playing()"), "the picture plays", within_s=30
        )
        await eventually(
            lambda: window.evaluate(f"/{WATCHING}/.test(document.body.innerText)"),
            "it says how many watch",
        )
        cards = [card for card in await window.evaluate("waxProbe.cards(40)") if card["valid"]]
        assert len(cards) >= 36
        assert median(card["age_ms"] for card in cards) < LIVE_MS
        tap = needed(ear).tap()
        await window.evaluate(button("Turn sound on"))
        assert await tap.hears(within_s=10)
        tap.take()
        await window.evaluate("waxProbe.cards(60)")
        assert audio_probe.loudness(tap.take()) > 0.02
        assert len((await server.status())["viewers"]) == 1, "only the operator has a place"
