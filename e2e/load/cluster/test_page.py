"""If the robot has no place for a page, it watches in a room, and comes for its turn."""

from __future__ import annotations

import json
import re
from statistics import median
from typing import TYPE_CHECKING, Any

import jwt
import pytest

from e2e.harness import probe
from e2e.harness.firefox import opened, presses
from e2e.harness.installed import needed
from e2e.harness.probe import LIVE_MS
from e2e.harness.robot import turn_by_key
from e2e.harness.viewer import Viewer
from e2e.harness.wait import eventually
from e2e.load.cluster.engine import KEY
from e2e.load.cluster.stage import published
from wax.client.operator import Operator

if TYPE_CHECKING:
    from pathlib import Path

    from playwright.async_api import Browser, Route

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server
    from e2e.load.cluster.engine import Engine
    from e2e.measure.ear import Ear

WATCHING = re.compile(r"\bwatch(es)?\.$")
REFUSED = 3
"""This often in a row; the page then waits for a second or two, in which a person can read."""

pytestmark = pytest.mark.timeout(150)


async def pages_here(server: Server) -> int:
    return len((await server.status())["viewers"])


async def has_observer(engine: Engine, number: int) -> bool:
    """Whether anybody who publishes nothing is in this node's room."""
    return any(not one["tracks"] for one in await engine.people(number))


async def watches_elsewhere(viewer: Viewer) -> None:
    """Wait until the page says how many watch, without naming them."""
    watching = viewer.page.get_by_text(WATCHING).first
    await watching.wait_for(state="visible", timeout=20_000)


@pytest.mark.parametrize("way", ["killed", "hangs"])
async def test_a_page_goes_to_the_other_room_when_its_node_is_lost(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer, way: str
) -> None:
    """It sees the robot without a place there, is told who drives, and survives a node's death."""
    async with published(serve, tmp_path) as (engine, server), Operator(server.url) as operator:
        await operator.join()
        viewer = await open_viewer(server)
        assert await pages_here(server) == 1, "only the operator has a place"
        await eventually(viewer.says_connected, "the page says that it is connected")
        await viewer.page.get_by_text("is driving").first.wait_for(state="visible")
        cards = await viewer.cards(5)
        assert all(card.valid for card in cards)
        (watched,) = [number for number in range(2) if await has_observer(engine, number)]
        if way == "killed":
            await engine.nodes[watched].kill()
        else:  # nothing closes there, and nothing arrives
            engine.nodes[watched].freeze()

        async def is_back() -> bool:
            newer = await viewer.cards(5)
            return newer[0].stamp_ms > cards[-1].stamp_ms and await viewer.says_connected()

        await eventually(
            lambda: has_observer(engine, 1 - watched), "it is in the other room", within_s=15
        )
        await eventually(is_back, "the picture is back from there", within_s=15)
        assert await pages_here(server) == 1


async def test_a_page_comes_for_its_turn_and_goes_back(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """It queues elsewhere, drives here, and releases the place when it leaves the queue."""
    turns = {"turns": "turn_s = 20.0"}
    async with published(serve, tmp_path, **turns) as (_, server), Operator(server.url) as operator:
        await operator.join()
        viewer = await open_viewer(server)
        await watches_elsewhere(viewer)
        await viewer.takes_the_wheel(30)
        assert not await viewer.page.get_by_text(WATCHING).count()
        await turn_by_key(server, viewer)
        await viewer.page.keyboard.up("ArrowLeft")
        await operator.gets_turn(within_s=30)
        await viewer.leave()
        await watches_elsewhere(viewer)
        before, after = await viewer.cards(3), await viewer.cards(3)
        assert after[-1].stamp_ms > before[0].stamp_ms
        assert await viewer.says_connected()


async def test_a_page_whose_tokens_have_expired_asks_for_others(
    serve: Serve, tmp_path: Path, chromium: Browser
) -> None:
    """It says that it cannot watch, asks the robot's server again, and then sees the robot."""
    async with (
        published(serve, tmp_path) as (_, server),
        Operator(server.url),
        await chromium.new_context() as context,
    ):
        answers: list[dict[str, Any]] = []

        async def late(route: Route) -> None:
            response = await route.fetch()
            answer = await response.json()
            answers.append(answer)
            if len(answers) <= REFUSED:
                for seat in answer["rooms"]:
                    seat["token"] = expired(seat["token"])
            await route.fulfill(response=response, body=json.dumps(answer))

        await context.route("**/api/offer", late)
        viewer = await Viewer.at(context, server.url)
        full = viewer.page.get_by_text("All places to watch are taken").first
        await full.wait_for(state="visible", timeout=10_000)
        await viewer.sees_picture(within_s=20)
        await eventually(viewer.says_connected, "the page says that it is connected")
        assert len(answers) == REFUSED + 1
        assert not viewer.errors


def expired(token: str) -> str:
    claims = jwt.decode(token, KEY.secret, algorithms=["HS256"])
    claims |= {name: claims[name] - 600 for name in ("nbf", "exp")}
    return jwt.encode(claims, KEY.secret, algorithm="HS256")


async def test_firefox_watches_in_a_room(serve: Serve, tmp_path: Path, ear: Ear | None) -> None:
    """The card is read live, the sound is heard, and no place at the robot is taken."""
    async with (
        published(serve, tmp_path) as (_, server),
        Operator(server.url),
        opened(server, tmp_path, needed(ear)) as window,
    ):
        is_told = "/(person watches|people watch)[.]/.test(document.body.innerText)"
        await eventually(lambda: window.evaluate(is_told), "it says how many watch")
        cards = [card for card in await window.evaluate("waxProbe.cards(40)") if card["valid"]]
        assert len(cards) >= 36
        assert median(card["age_ms"] for card in cards) < LIVE_MS
        tap = needed(ear).tap()
        await presses(window, "Turn sound on")
        assert await tap.hears(within_s=10)
        tap.take()
        await window.evaluate("waxProbe.cards(60)")
        assert probe.loudness(tap.take()) > 0.02
        assert len((await server.status())["viewers"]) == 1, "only the operator has a place"
