"""A cluster, and a server with one place of its own that publishes into both rooms."""

from __future__ import annotations

import asyncio
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final, Literal

import tomlkit

from e2e.harness import toml
from e2e.harness.board import Board
from e2e.harness.server import Server
from e2e.load.cluster.engine import KEY, ROOMS, Engine, running
from e2e.load.process import pinned, two_cores
from e2e.load.servers import SETTINGS

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from e2e.conftest import Serve
    from e2e.load.cluster.page import Page

_LIVE_WITHIN_S: Final = 30.0
_LOOK_S: Final = 0.05


def rooms(engine: Engine) -> list[dict[str, Any]]:
    """Return the configuration's `publish`: the room of each node."""
    key = {"api_key": KEY.name, "api_secret": KEY.secret}
    return [
        {"livekit": engine.url(number), "room": room, **key} for number, room in enumerate(ROOMS)
    ]


async def are_live(server: Server, count: int, within_s: float) -> None:
    await server.until(
        lambda told: [room["is_live"] for room in told["rooms"]].count(True) == count,
        f"{count} rooms are live",
        within_s=within_s,
    )


@asynccontextmanager
async def published(
    serve: Serve, folder: Path, **settings: str
) -> AsyncIterator[tuple[Engine, Server]]:
    """Run both for a test, or skip it if they are missing; `settings` as in `toml.card_with`."""
    async with running() as engine:
        tables = "\n".join(f"[[publish]]\n{tomlkit.dumps(room)}" for room in rooms(engine))
        text = toml.card_with(server="max_viewers = 1", **settings) + tables
        async with serve(folder, text) as server:
            await are_live(server, 2, within_s=20)
            yield engine, server


@dataclass(frozen=True, slots=True)
class Stage:
    """For a measurement: the server drives a board, and its side runs on `robots_core`."""

    engine: Engine
    server: Server
    board: Board
    robots_core: int

    def watched(self, page: Page) -> int:
        """Return the number of the node in whose room a page is; raises `MeasureError`."""
        urls = [self.engine.url(number) for number in range(len(self.engine.nodes))]
        return next(at for at, url in enumerate(urls) if page.room_url.startswith(url))

    async def is_live(self, number: int, *, live: bool) -> None:
        """Wait until the server publishes into the room of a node, or knows that it does not."""
        what = f"node {number} is {'published to' if live else 'given up'}"
        await self.server.until(
            lambda told: told["rooms"][number]["is_live"] is live,
            what,
            within_s=_LIVE_WITHIN_S,
            every_s=_LOOK_S,
        )

    async def are_live(self) -> None:
        await asyncio.gather(*(self.is_live(at, live=True) for at in range(len(ROOMS))))


@asynccontextmanager
async def staged(
    alone: Literal["robot", "engine"] = "robot", **settings: Any
) -> AsyncIterator[Stage]:
    """Run it inside the block, with both rooms published to; `settings` are the server's tables.

    One side has a core of its own, as if it were another machine: the robot's server and the
    operator, or the cluster. Raises `NotRunError` if LiveKit, Redis or a second core is missing.
    """
    own_core, others_core = two_cores()
    robots_core, engines_core = (
        (own_core, others_core) if alone == "robot" else (others_core, own_core)
    )
    async with AsyncExitStack() as leaving:
        leaving.enter_context(pinned(others_core))
        folder = Path(leaving.enter_context(TemporaryDirectory(prefix="wax-load-")))
        log = leaving.enter_context((folder / "engine.log").open("w"))
        with pinned(engines_core):
            engine = await leaving.enter_async_context(running(log))
        board = Board(folder)
        tables = {"publish": rooms(engine), "robot": board.robot, "server": {"max_viewers": 1}}
        server = Server(folder, tomlkit.dumps(toml.merged(SETTINGS, tables, settings)))
        with pinned(robots_core):
            await leaving.enter_async_context(board)
            leaving.push_async_callback(server.kill)
            await server.start()
        stage = Stage(engine, server, board, robots_core)
        await stage.are_live()
        yield stage
