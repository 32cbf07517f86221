"""A server that publishes into both rooms of a cluster, and has one place of its own."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

from e2e.harness import toml
from e2e.harness.wait import eventually
from e2e.load.cluster.engine import KEY, ROOMS, Engine, running

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from e2e.conftest import Serve
    from e2e.harness.server import Server


def rooms(engine: Engine) -> list[dict[str, Any]]:
    """Return the configuration's `publish`: the room of each node."""
    return [
        {
            "livekit": engine.url(number),
            "room": room,
            "api_key": KEY.name,
            "api_secret": KEY.secret,
        }
        for number, room in enumerate(ROOMS)
    ]


def configuration(engine: Engine, **settings: str) -> str:
    """Publish the test card into the room of each node, with one place here."""
    tables = "\n".join(f"[[publish]]\n{toml.dumps(room)}" for room in rooms(engine))
    return toml.card_with(server="max_viewers = 1", **settings) + tables


@asynccontextmanager
async def published(
    serve: Serve, folder: Path, **settings: str
) -> AsyncIterator[tuple[Engine, Server]]:
    """Have a server that publishes into both rooms of a cluster; `settings` as `toml.card_with`."""
    async with running() as engine, serve(folder, configuration(engine, **settings)) as server:
        await eventually(lambda: are_live(server, 2), "both rooms are published to", within_s=20)
        yield engine, server


async def are_live(server: Server, count: int) -> bool:
    told: list[dict[str, Any]] = (await server.status())["elsewhere"]
    return [room["is_live"] for room in told].count(True) == count
