"""The sound, as it leaves the browser."""

from __future__ import annotations

import asyncio
from statistics import median
from typing import TYPE_CHECKING

import pytest
import pytest_asyncio

from e2e.harness import audio_probe, toml
from e2e.harness.missing import needed
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer
    from e2e.measure.ear import Ear


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def server(serve: Serve, tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Server]:
    async with serve(tmp_path_factory.mktemp("sound"), toml.CARD) as running:
        yield running


async def packets_stand_still(viewer: Viewer, kind: str) -> bool:
    before = await viewer.packets(kind)
    await asyncio.sleep(1.5)
    return await viewer.packets(kind) == before


@pytest.mark.timeout(90)
async def test_silent_until_start(server: Server, open_viewer: OpenViewer, ear: Ear | None) -> None:
    """Nothing is audible while the picture already plays; pressing Start makes it so."""
    viewer = await open_viewer(server)
    await viewer.cards(15)
    tap = needed(ear).tap()
    assert not await tap.hears(within_s=2)
    await viewer.listen()
    await asyncio.sleep(2)
    assert audio_probe.loudness(viewer.heard()) > 0.02


@pytest.mark.timeout(90)
@pytest.mark.full
async def test_both_tones_of_the_card_are_heard(server: Server, open_viewer: OpenViewer) -> None:
    """The quiet tone plays without a gap, and a burst follows each whole second at once."""
    viewer = await open_viewer(server)
    await viewer.listen()
    await asyncio.sleep(3)
    viewer.forget()
    await asyncio.sleep(6)
    blocks = viewer.heard()
    assert 0.02 < median(block.tone for block in blocks) < 0.1
    assert max(block.burst for block in blocks) > 0.2
    ages_ms = audio_probe.burst_ages_ms(blocks)
    assert 5 <= len(ages_ms) <= 7, ages_ms
    assert all(age < 500 for age in ages_ms), ages_ms
    assert sum(audio_probe.gaps_ms(blocks)) <= 60, audio_probe.gaps_ms(blocks)


@pytest.mark.timeout(90)
async def test_switching_the_sound_off_stops_its_packets(
    server: Server, open_viewer: OpenViewer
) -> None:
    """With Sound off none is sent nor encoded, the picture goes on; on again, it is heard again."""
    viewer = await open_viewer(server)
    await viewer.listen()
    await viewer.switch("Sound").click()
    await eventually(
        lambda: packets_stand_still(viewer, "audio"), "no audio packet arrives", within_s=6
    )
    assert not await packets_stand_still(viewer, "video")

    async def rests() -> bool:
        streams = (await server.status())["streams"]
        return not streams["audio"]["encoded_hz"]

    await eventually(rests, "no sound is encoded that nobody wants", within_s=6)
    await viewer.switch("Sound").click()

    async def heard_again() -> bool:
        viewer.forget()
        await asyncio.sleep(1)
        return audio_probe.loudness(viewer.heard()) > 0.02

    await eventually(heard_again, "the sound is heard again", within_s=8)


@pytest.mark.full
@pytest.mark.timeout(90)
async def test_one_viewers_switch_does_not_touch_another(
    server: Server, open_viewer: OpenViewer
) -> None:
    """A viewer who switches sound and picture off takes neither from the other."""
    first, second = await open_viewer(server), await open_viewer(server)
    await first.open("Settings")
    await first.switch("Picture").click()
    if await first.button("Turn sound on").is_visible():
        await first.button("Turn sound on").click()
    await first.switch("Sound").click()
    await eventually(
        lambda: packets_stand_still(first, "video"), "no video packet arrives", within_s=6
    )
    stamps = [card.stamp_ms for card in await second.cards(20) if card.valid]
    assert stamps[-1] - stamps[0] > 400
    assert not await packets_stand_still(second, "video")
