"""What every case needs: a cluster, and a server that publishes into it and drives a board."""

from __future__ import annotations

import asyncio
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final

from e2e.harness import toml
from e2e.harness.board import Board
from e2e.harness.server import Server
from e2e.harness.wait import eventually
from e2e.load.cluster import published
from e2e.load.cluster.engine import Engine, installed
from e2e.load.process import pinned, two_cores

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from e2e.load.cluster.page import Page

ENGINES_OWN_S: Final = 5.5
"""So long LiveKit counts a dead node among the living; one that is started before gets no rooms."""
_LIVE_WITHIN_S: Final = 30.0
_LOOK_S: Final = 0.05
_CARD: Final[dict[str, Any]] = {
    "video": {"source": "testcard"},
    "audio": {"source": "testcard"},
    "turns": {"turn_s": 3600.0, "grace_s": 0.5},
}


@dataclass(frozen=True, slots=True)
class Stage:
    folder: Path
    engine: Engine
    server: Server
    board: Board
    robots_core: int | None
    """Where the robot's side runs; None is anywhere."""

    def watched(self, page: Page) -> int:
        """Return the number of the node in whose room a page is; raises `MeasureError`."""
        urls = [self.engine.url(number) for number in range(len(self.engine.nodes))]
        return next(at for at, url in enumerate(urls) if page.room_url.startswith(url))

    async def is_live(self, number: int, *, live: bool) -> None:
        """Wait until the server publishes into the room of a node, or knows that it does not."""

        async def is_so() -> bool:
            rooms = (await self.server.status())["elsewhere"]
            return bool(rooms[number]["is_live"]) is live

        what = f"node {number} is {'published to' if live else 'given up'}"
        await eventually(is_so, what, within_s=_LIVE_WITHIN_S, every_s=_LOOK_S)

    async def are_live(self) -> None:
        """Wait until both rooms are published to."""
        await asyncio.gather(*(self.is_live(number, live=True) for number in range(2)))


@asynccontextmanager
async def staged(*, is_apart: bool = False, **settings: Any) -> AsyncIterator[Stage]:
    """Have it inside the block, with both rooms published to; `settings` are tables of the server.

    With `is_apart` cluster and pages have one core, and the robot's server and its operator the
    other, as if they were other machines. Raises `NotRunError` where LiveKit or Redis is missing.
    """
    cores = two_cores() if is_apart else None
    robots_core, others_core = cores or (None, None)
    async with AsyncExitStack() as leaving:
        leaving.enter_context(pinned(others_core))
        folder = Path(leaving.enter_context(TemporaryDirectory(prefix="wax-cluster-")))
        log = leaving.enter_context((folder / "engine.log").open("w", encoding="utf-8"))
        engine = installed(log)
        leaving.push_async_callback(engine.stop)
        await engine.start()
        board = Board(folder)
        with pinned(robots_core):
            await board.start()
        leaving.push_async_callback(board.stop)
        robot = {"driver": "serial", "serial": {"url": str(board.path)}}
        tables = {"publish": published.rooms(engine), "robot": robot}
        server = Server(folder, toml.dumps(toml.merged(_CARD, tables, settings)))
        leaving.push_async_callback(server.kill)
        with pinned(robots_core):
            await server.start()
        stage = Stage(folder, engine, server, board, robots_core)
        await stage.are_live()
        yield stage
