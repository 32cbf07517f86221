"""A film with a voice as the camera and microphone, through the real demuxer."""

from __future__ import annotations

import asyncio
from itertools import pairwise
from statistics import median
from typing import TYPE_CHECKING

import numpy as np
import pytest

from e2e.harness.server import Server
from e2e.harness.speech import envelope, find_in_loop, voice, write_film
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.conftest import OpenViewer, Serve

FILM_S = 9.0
SKEW_MS = 45.0
"""ITU-R BT.1359: sound that is earlier is noticed; later would be let pass up to 125."""


def settings(film: Path) -> str:
    return f'[video]\nsource = "{film}"\n[audio]\nsource = "{film}"\n'


@pytest.mark.timeout(120)
@pytest.mark.full
async def test_a_voice_is_heard_in_step_with_its_picture(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """What is heard is the file's own voice at its own speed, in step with the file's picture."""
    sound = voice(FILM_S)
    film = tmp_path / "film.mp4"
    await asyncio.to_thread(write_film, film, sound, FILM_S)
    async with serve(tmp_path, settings(film)) as server:
        viewer = await open_viewer(server)
        await viewer.listen()
        for _ in range(3):  # until the browser has settled on a delay, it stretches the sound
            await asyncio.sleep(3)
            viewer.forget()
            cards = await viewer.cards(100)
            await asyncio.sleep(1)
            blocks = (viewer.heard())[:400]
            heard = np.array([block.rms for block in blocks])
            place, fit = await asyncio.to_thread(find_in_loop, heard, envelope(sound))
            if fit > 0.8:
                break
    assert fit > 0.8, f"what is heard fits the voice by {fit:.2f} only"

    loop_ms = FILM_S * 1000
    valid = [card for card in cards if card.valid]
    assert len(valid) > 0.9 * len(cards)
    skews_ms = []
    for card in valid:
        sound_place_ms = place * 10 + card.now_ms - blocks[0].start_ms
        skew_ms = card.stamp_ms - sound_place_ms
        skews_ms.append((skew_ms + loop_ms / 2) % loop_ms - loop_ms / 2)
    print(f"film: fit {fit:.2f}, skew {median(skews_ms):+.0f} ms (sound late is positive)")
    assert abs(median(skews_ms)) <= SKEW_MS

    seconds = (valid[-1].now_ms - valid[0].now_ms) / 1000
    played = ((valid[-1].stamp_ms - valid[0].stamp_ms) % loop_ms) / 1000
    assert abs(played - seconds) < 0.15, f"{played:.2f} s of film in {seconds:.2f} s"


@pytest.mark.timeout(90)
@pytest.mark.full
async def test_a_film_without_sound_plays(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """A film that has no sound is shown, and the page says that the sound is missing."""
    film = tmp_path / "silent.mp4"
    await asyncio.to_thread(write_film, film, None, 3)
    async with serve(tmp_path, settings(film)) as server:
        viewer = await open_viewer(server)
        cards = await viewer.cards(60)
        assert len({card.stamp_ms for card in cards if card.valid}) > 30
        text = viewer.page.get_by_text("no sound", exact=False)
        await text.first.wait_for(state="visible", timeout=3000)


@pytest.mark.timeout(90)
@pytest.mark.full
async def test_a_film_cut_in_the_middle_plays_as_far_as_it_goes(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """A file whose end is missing is played and looped; the server does not end."""
    whole = tmp_path / "whole.mkv"
    await asyncio.to_thread(write_film, whole, voice(4), 4)
    octets = whole.read_bytes()
    film = tmp_path / "cut.mkv"
    film.write_bytes(octets[: len(octets) * 2 // 3])
    async with serve(tmp_path, settings(film)) as server:
        viewer = await open_viewer(server)

        async def plays_again() -> bool:
            stamps = [card.stamp_ms for card in await viewer.cards(90) if card.valid]
            return any(b < a for a, b in pairwise(stamps))

        await eventually(plays_again, "the film begins again", within_s=20)


@pytest.mark.timeout(30)
@pytest.mark.parametrize("content", [b"These are words, no film.\n" * 40, b"", None])
async def test_what_is_no_film_keeps_the_server_from_starting(
    tmp_path: Path, content: bytes | None
) -> None:
    """A text, an empty or a missing file: exit status not 0 and a sentence that names the file."""
    film = tmp_path / "film.mp4"
    if content is not None:
        film.write_bytes(content)
    server = Server(tmp_path, settings(film))
    await server.launch()
    try:
        assert await server.exit_code(within_s=10) != 0
    finally:
        await server.kill()
    assert "film.mp4" in server.log
    assert "Traceback" not in server.log
    assert len(server.log.strip().splitlines()) <= 3, server.log
