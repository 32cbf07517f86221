"""The baseline in a real browser: the thesis's codecs, acknowledged units, nobody just watching."""

from __future__ import annotations

import asyncio
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
import tomlkit

from e2e.harness import probe

if TYPE_CHECKING:
    from e2e.conftest import OpenViewer, Serve

CONFIG = Path(__file__).parents[1] / "config" / "thesis.toml"


def thesis() -> str:
    """Return the shipped file with the test card prepended."""
    tree = tomllib.loads(CONFIG.read_text(encoding="utf-8"))
    tree["video"]["source"] = "testcard"  # its stamp is at the top, the overlay of the time below
    tree["audio"] = {"source": "testcard"}
    return tomlkit.dumps(tree)


@pytest.mark.full
async def test_the_browser_plays_the_system_of_2004(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """Only µ-law and keyframes, each unit acknowledged, in step and half a second old.

    Whoever opens the page drives or waits, without asking (thesis 3.1).
    """
    async with serve(tmp_path, thesis()) as server:
        viewer = await open_viewer(server)
        await viewer.listen()
        await server.until(
            lambda told: told["viewers"][0]["streams"]["mode"] == "synchronised",
            "sound and picture are in step",
            within_s=20,
        )
        assert await viewer.probe("codec('audio')") == "audio/PCMU"
        await asyncio.sleep(3)  # until the browser's buffer has the length of a unit
        viewer.forget()
        before = await viewer.inbound("video")
        cards = await viewer.cards(25)
        after = await viewer.inbound("video")
        assert after["frameWidth"] == 166
        for counts in (before, after):  # some wait to be decoded, and Chromium 150 counts them
            assert counts["framesDecoded"] <= counts["keyFramesDecoded"] <= counts["framesReceived"]
        assert after["framesDecoded"] - before["framesDecoded"] > 15
        assert [card for card in cards if card.valid]
        assert probe.loudness(viewer.heard()) > 0.02
        (told,) = (await server.status())["viewers"]
        assert told["role"] == "operator"  # without having asked
        assert told["streams"]["sent"] > 60
        assert told["streams"]["lost"] == 0
        # The policy's lowest delay is half a second.
        ages_ms = sorted(card.age_ms for card in cards if card.valid)
        assert ages_ms[len(ages_ms) // 2] > 400
