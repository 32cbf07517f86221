"""The picture, read off the glass."""

from __future__ import annotations

import re
from statistics import median
from typing import TYPE_CHECKING

import pytest
import pytest_asyncio

from e2e.harness import toml
from e2e.harness.video_probe import assert_live
from e2e.harness.wait import eventually
from e2e.load.servers import STOCK, serving

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

SOUND_MS = 100.0
"""As old as the sound is that the picture is held back for, at most."""
MIME_TYPE = {"vp8": "video/VP8", "h264": "video/H264"}


@pytest.fixture(scope="module", params=["vp8", pytest.param("h264", marks=pytest.mark.full)])
def codec(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def server(
    serve: Serve, codec: str, tmp_path_factory: pytest.TempPathFactory
) -> AsyncIterator[Server]:
    async with serve(tmp_path_factory.mktemp(codec), toml.card(codec)) as running:
        yield running


@pytest.mark.timeout(90)
async def test_card_moves_and_is_fresh(server: Server, codec: str, open_viewer: OpenViewer) -> None:
    """The test card read off presented frames is whole, moves on and is new."""
    viewer = await open_viewer(server)
    assert_live(await viewer.cards(45))
    assert await viewer.probe("codec('video')") == MIME_TYPE[codec]


@pytest.mark.timeout(120)
@pytest.mark.full
async def test_the_operators_picture_is_fresher_than_stocks(
    server: Server, open_viewer: OpenViewer
) -> None:
    """It is at most seven tenths as old as a stock server's in the same browser and minute."""
    async with serving(STOCK) as stock:
        ours, theirs = await open_viewer(server), await open_viewer(stock)
        await ours.join()
        await ours.drives()
        ages_ms: dict[Viewer, list[float]] = {ours: [], theirs: []}
        for viewer in [ours, theirs] * 4:  # in turn, so that both meet the same machine
            ages_ms[viewer] += [card.age_ms for card in await viewer.cards(20) if card.valid]
        ours_ms, theirs_ms = (median(ages_ms[viewer]) for viewer in (ours, theirs))
        assert ours_ms <= 0.7 * theirs_ms, f"{ours_ms:.0f} ms, stock's {theirs_ms:.0f} ms"


@pytest.mark.timeout(90)
@pytest.mark.full
async def test_rate_is_that_of_the_rendition(server: Server, open_viewer: OpenViewer) -> None:
    """About thirty different pictures a second are presented at the default size."""
    viewer = await open_viewer(server)
    await viewer.cards(30)
    cards = await viewer.cards(90)
    seconds = (cards[-1].now_ms - cards[0].now_ms) / 1000
    shown = len({card.stamp_ms for card in cards}) - 1
    assert 24 <= shown / seconds <= 33, f"{shown / seconds:.1f} pictures a second"


@pytest.mark.timeout(120)
async def test_every_offered_size_is_shown(server: Server, open_viewer: OpenViewer) -> None:
    """Each size in the select is what is presented after it is chosen, whole and live."""
    viewer = await open_viewer(server)
    await viewer.open("Settings")
    labels = await viewer.size.locator("option").all_inner_texts()
    sizes = [tuple(int(n) for n in re.findall(r"\d+", label)[:2]) for label in labels]
    assert {(640, 480), (320, 240), (160, 120)} == set(sizes), labels
    for index in [1, 2, 0]:
        await viewer.size.select_option(index=index)
        await shows_size(viewer, *sizes[index])
        assert_live(await viewer.cards(20))


async def shows_size(viewer: Viewer, width: int, height: int) -> None:
    async def shown() -> bool:
        newest = (await viewer.cards(1))[0]
        return (newest.width, newest.height) == (width, height)

    await eventually(shown, f"the picture is {width}×{height}", within_s=8)


@pytest.mark.timeout(90)
async def test_switching_the_picture_off_stops_its_packets(
    server: Server, open_viewer: OpenViewer
) -> None:
    """With Picture off none is sent nor encoded, sound goes on; on again, the card is live."""
    viewer = await open_viewer(server)
    await viewer.button("Turn sound on").click()
    await viewer.open("Settings")
    await viewer.switch("Picture").click()

    async def silent() -> bool:
        before = await viewer.packets("video")
        await viewer.page.wait_for_timeout(1500)
        return await viewer.packets("video") == before

    async def rests() -> bool:
        streams = (await server.status())["streams"]
        return not streams["video"]["wanted"] and not any(streams["video"]["encoded_fps"].values())

    await eventually(silent, "no video packet arrives any more", within_s=6)
    await eventually(rests, "nothing is encoded that nobody wants", within_s=6)
    heard = await viewer.packets("audio")
    await viewer.page.wait_for_timeout(500)
    assert await viewer.packets("audio") > heard
    await viewer.switch("Picture").click()
    await viewer.sees_picture()
    await viewer.cards(5)
    assert_live(await viewer.cards(20), held_ms=SOUND_MS)
