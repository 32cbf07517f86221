"""The picture, read off the presented frames."""

from __future__ import annotations

import re
from itertools import pairwise
from statistics import median
from typing import TYPE_CHECKING

import pytest
import pytest_asyncio
import tomlkit

from e2e.harness import toml
from e2e.harness.probe import assert_live
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

SOUND_MS = 100.0
"""At most as old as the sound for which the picture is held back."""
MIME_TYPE = {"vp8": "video/VP8", "h264": "video/H264"}


@pytest.fixture(scope="module", params=["vp8", "h264"])
def codec(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def server(
    serve: Serve, codec: str, tmp_path_factory: pytest.TempPathFactory
) -> AsyncIterator[Server]:
    settings = tomlkit.dumps(toml.merged(toml.MEDIA, {"video": {"codec": codec}}))
    async with serve(tmp_path_factory.mktemp(codec), settings) as running:
        yield running


@pytest.mark.full
@pytest.mark.timeout(120)
async def test_every_offered_size_is_fresh_until_it_is_switched_off(
    server: Server, codec: str, open_viewer: OpenViewer
) -> None:
    """The card is whole, new and of the chosen size, with 30 pictures captured a second.

    Switched off, none is sent or encoded while sound continues; on again it is live.
    """
    viewer = await open_viewer(server)
    assert_live(await viewer.cards(20))
    assert await viewer.probe("codec('video')") == MIME_TYPE[codec]
    await viewer.open("Settings")
    size = viewer.page.get_by_role("combobox", name="Picture size", exact=True)
    labels = await size.locator("option").all_inner_texts()
    sizes = [tuple(int(n) for n in re.findall(r"\d+", label)[:2]) for label in labels]
    assert {(640, 480), (320, 240), (160, 120)} == set(sizes), labels
    for index in [1, 2, 0]:
        await size.select_option(index=index)
        await shows_size(viewer, *sizes[index])
        assert_live(await viewer.cards(20))

    async def is_smooth() -> bool:
        """Return whether most pictures are consecutive, whatever a busy machine leaves out."""
        stamps_ms = sorted({card.stamp_ms for card in await viewer.cards(20) if card.valid})
        apart_ms = [b - a for a, b in pairwise(stamps_ms)]
        return bool(apart_ms) and 1000 / 33 <= median(apart_ms) <= 1000 / 24

    await eventually(is_smooth, "30 pictures a second are captured")

    await viewer.button("Turn sound on").click()
    await viewer.switch("Picture").click()

    async def rests() -> bool:
        before = await viewer.packets("video")
        await viewer.page.wait_for_timeout(700)
        video = (await server.status())["streams"]["video"]
        is_silent = await viewer.packets("video") == before
        return is_silent and not video["wanted"] and not any(video["encoded_fps"].values())

    await eventually(rests, "nothing is sent nor encoded that nobody wants", within_s=20)
    await viewer.receives_more("audio")
    await viewer.switch("Picture").click()
    await viewer.sees_picture()
    await viewer.cards(5)
    assert_live(await viewer.cards(20), held_ms=SOUND_MS)


async def shows_size(viewer: Viewer, width: int, height: int) -> None:
    async def shown() -> bool:
        newest = (await viewer.cards(1))[0]
        return (newest.width, newest.height) == (width, height)

    await eventually(shown, f"the picture is {width}×{height}", within_s=20)
