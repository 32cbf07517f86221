"""The page where the robot has no place for it: it watches in a room, and comes for its turn."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import pytest

from e2e.harness.robot import turn_by_key
from e2e.harness.wait import eventually
from e2e.load.cluster.published import published
from wax.client.operator import Operator

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer
    from e2e.load.cluster.engine import Engine

WATCHING = re.compile(r"\bwatch(es)?\.$")

pytestmark = pytest.mark.timeout(150)


async def pages_here(server: Server) -> int:
    return len((await server.status())["viewers"])


async def has_observer(engine: Engine, number: int) -> bool:
    """Whether somebody is in the room of this node who publishes nothing."""
    return any(not one["tracks"] for one in await engine.people(number))


async def watches_elsewhere(viewer: Viewer) -> bool:
    """Whether the page says how many watch, of whom it has no list."""
    return await viewer.page.get_by_text(WATCHING).count() > 0


async def test_a_page_watches_in_a_room_and_goes_to_the_other_when_its_node_dies(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """It sees the robot without a place there, is told who drives, and survives a node."""
    async with published(serve, tmp_path) as (engine, server), Operator(server.url) as operator:
        await operator.join()
        viewer = await open_viewer(server)
        assert await pages_here(server) == 1, "only the operator has a place"
        await eventually(viewer.says_connected, "the page says that it is connected")
        await viewer.page.get_by_text("is driving").first.wait_for(state="visible")
        cards = await viewer.cards(5)
        assert all(card.valid for card in cards)
        (watched,) = [number for number in range(2) if await has_observer(engine, number)]
        await engine.nodes[watched].kill()

        async def is_back() -> bool:
            newer = await viewer.cards(5)
            return newer[0].stamp_ms > cards[-1].stamp_ms and await viewer.says_connected()

        await eventually(is_back, "the picture is back from the other room", within_s=15)
        assert await pages_here(server) == 1


async def test_a_page_comes_for_its_turn_and_goes_back(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """It queues elsewhere, drives here, and gives the place back when it leaves the queue."""
    turns = {"turns": "turn_s = 20.0"}
    async with (
        published(serve, tmp_path, **turns) as (_, server),
        Operator(server.url) as operator,
    ):
        await operator.join()
        viewer = await open_viewer(server)
        await eventually(lambda: watches_elsewhere(viewer), "it watches in a room")
        await viewer.join()
        await viewer.drives(within_s=30)
        assert not await watches_elsewhere(viewer)
        await turn_by_key(server, viewer)
        await viewer.page.keyboard.up("ArrowLeft")
        await operator.gets_turn(within_s=30)
        await viewer.leave()
        await eventually(
            lambda: watches_elsewhere(viewer), "it watches in the room again", within_s=20
        )
        before = await viewer.cards(3)
        after = await viewer.cards(3)
        assert after[-1].stamp_ms > before[0].stamp_ms
        assert await viewer.says_connected()
