"""The page in a room when something there is wrong: tokens refused, a node frozen, a blank card."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import jwt
import pytest

from e2e.harness.viewer import Viewer
from e2e.harness.wait import eventually
from e2e.load.cluster.engine import KEY
from e2e.load.cluster.published import published
from e2e.load.cluster.test_page_elsewhere import has_observer, pages_here, watches_elsewhere
from e2e.test_strangers import BLACK, LUMA, SILENT
from wax.client.client import Client
from wax.client.operator import Operator

if TYPE_CHECKING:
    from pathlib import Path

    from playwright.async_api import Browser, Route

    from e2e.conftest import OpenViewer, Serve

pytestmark = pytest.mark.timeout(150)

REFUSED = 3
"""So often in a row; the page then waits for a second or two, in which a person can read."""


def expired(token: str) -> str:
    """Return the same token as it was ten minutes ago."""
    claims = jwt.decode(token, KEY.secret, algorithms=["HS256"])
    claims |= {name: claims[name] - 600 for name in ("nbf", "exp")}
    return jwt.encode(claims, KEY.secret, algorithm="HS256")


async def test_a_page_whose_tokens_have_expired_asks_for_others(
    serve: Serve, tmp_path: Path, chromium: Browser
) -> None:
    """It says that it cannot watch, asks the robot's server again, and sees the robot."""
    async with published(serve, tmp_path) as (_, server), Operator(server.url):
        context = await chromium.new_context()
        answers: list[dict[str, Any]] = []

        async def late(route: Route) -> None:
            response = await route.fetch()
            answer = await response.json()
            answers.append(answer)
            if len(answers) <= REFUSED:
                for seat in answer["rooms"]:
                    seat["token"] = expired(seat["token"])
            await route.fulfill(response=response, body=json.dumps(answer))

        try:
            await context.route("**/api/offer", late)
            viewer = await Viewer.prepare(context, server.url)
            await viewer.page.goto(server.url)
            full = viewer.page.get_by_text("Watching is full").first
            await full.wait_for(state="visible", timeout=10_000)
            await viewer.sees_picture(within_s=20)
            await eventually(viewer.says_connected, "the page says that it is connected")
            assert len(answers) == REFUSED + 1
            assert not viewer.errors
        finally:
            await context.close()


async def test_a_page_leaves_a_node_that_hangs(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """Nothing closes there, and nothing comes: the picture is back from the other room."""
    async with published(serve, tmp_path) as (engine, server), Operator(server.url):
        viewer = await open_viewer(server)
        await eventually(lambda: watches_elsewhere(viewer), "it watches in a room")
        before = await viewer.cards(5)
        (watched,) = [number for number in range(2) if await has_observer(engine, number)]
        engine.nodes[watched].freeze()

        async def is_back() -> bool:
            newer = await viewer.cards(5)
            return newer[0].stamp_ms > before[-1].stamp_ms and await viewer.says_connected()

        await eventually(
            lambda: has_observer(engine, 1 - watched), "it is in the other room", within_s=15
        )
        await eventually(is_back, "the picture is back from there", within_s=15)
        assert await pages_here(server) == 1


async def test_blanked_there_is_nothing_to_see_in_a_room(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """The picture is black and the sound silent elsewhere, too, until the host is done."""
    async with (
        published(serve, tmp_path) as (_, server),
        Client(server.url, cookies=await server.host_cookies()) as host,
        Operator(server.url),
    ):
        viewer = await open_viewer(server)
        await eventually(lambda: watches_elsewhere(viewer), "it watches in a room")
        await viewer.listen()

        async def is_dark() -> bool:
            return bool(await viewer.page.evaluate(LUMA) <= BLACK)

        async def is_bright() -> bool:
            return not await is_dark()

        async def is_silent() -> bool:
            viewer.forget()
            await viewer.cards(15)
            heard = viewer.heard()
            return bool(heard) and all(block.rms <= SILENT for block in heard)

        assert await is_bright()
        host.say(type="blank", blanked=True)
        await eventually(is_dark, "the picture is black")
        await eventually(is_silent, "and there is no sound")
        host.say(type="blank", blanked=False)
        await eventually(is_bright, "the robot's picture is back")
