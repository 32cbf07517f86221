"""Two nodes of LiveKit on one Redis, and a room pinned to each."""

from __future__ import annotations

import asyncio
import shutil
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any, Final, TextIO

import aiohttp
from tests.free_port import free_port

from e2e.harness.child import kill
from e2e.harness.wait import eventually
from e2e.measure.errors import NotRunError
from e2e.peers.livekit.installation import find_server
from e2e.peers.livekit.server import LiveKit, Ports
from e2e.peers.livekit.tokens import Key, signed

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import AsyncIterator

KEY: Final = Key("APItest", "s" * 32)
ROOMS: Final = ("robot-1", "robot-2")
_ADDRESS: Final = "127.0.0.1"
_SELECTOR: Final = {
    "kind": "regionaware",
    "sort_by": "rooms",
    "sysload_limit": 1_000_000,
    "regions": [{"name": room, "lat": 0, "lon": 90 * at} for at, room in enumerate(ROOMS)],
}
"""As in config/deploy: even a recreated room lives on the node that was asked for it."""


class Redis:
    """Connects the nodes; it stores nothing on disk."""

    def __init__(self) -> None:
        self.port = free_port()
        self._process: Process | None = None

    async def start(self) -> None:
        self._process = await asyncio.create_subprocess_exec(
            *("redis-server", "--port", str(self.port), "--bind", _ADDRESS),
            *("--save", "", "--appendonly", "no"),
            stdout=asyncio.subprocess.DEVNULL,
        )

        async def answers() -> bool:
            return "PONG" in await self._ask("PING")

        await eventually(answers, "Redis answers")

    async def kill(self) -> None:
        """End it as a power cut does; safe to call twice."""
        await kill(self._process)

    async def nodes(self) -> set[str]:
        """Return the ids of the nodes, which are random at each start."""
        return set((await self._ask("HKEYS", "nodes")).split())

    async def nodes_of_rooms(self) -> set[str]:
        return set((await self._ask("HVALS", "room_node_map")).split())

    async def _ask(self, *command: str) -> str:
        process = await asyncio.create_subprocess_exec(
            *("redis-cli", "-p", str(self.port), *command),
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.DEVNULL,
        )
        return (await process.communicate())[0].decode()


class Engine:
    """The cluster; `nodes` in the order of `ROOMS`, each of which has its room.

    Raises `NotRunError` where LiveKit or Redis is missing.
    """

    def __init__(self, log: TextIO | None) -> None:
        if shutil.which("redis-server") is None:
            raise NotRunError("there is no Redis; install the package redis-server")
        program = find_server()
        self.redis = Redis()
        self.nodes = [
            LiveKit(
                program,
                _ADDRESS,
                Ports(free_port(), free_port(), free_port()),
                KEY,
                log=log,
                region=room,
                rtc={"use_ice_lite": True},
                redis={"address": f"{_ADDRESS}:{self.redis.port}"},
                node_selector=_SELECTOR,
            )
            for room in ROOMS
        ]

    async def start(self) -> None:
        """Start all, and pin each room to its node."""
        await self.redis.start()
        for node, name in zip(self.nodes, ROOMS, strict=True):
            before = await self.redis.nodes()
            await node.start()

            async def new(before: set[str] = before) -> set[str]:
                return await self.redis.nodes() - before

            (pinned,) = await eventually(new, "Redis knows the node")
            # With the configuration that the origin would request.
            room = {"name": name, "node_id": pinned, "empty_timeout": 600}
            room |= {"sync_streams": True, "max_playout_delay": 200}
            await call(node.url, "CreateRoom", room)

    async def stop(self) -> None:
        for node in self.nodes:
            await node.kill()
        await self.redis.kill()

    def url(self, number: int) -> str:
        return self.nodes[number].url.replace("http", "ws", 1)

    async def people(self, number: int) -> list[dict[str, Any]]:
        """Return who is in the room of this node, and what they publish."""
        told = await call(self.nodes[number].url, "ListParticipants", {"room": ROOMS[number]})
        people: list[dict[str, Any]] = told["participants"]
        return people


async def call(url: str, what: str, body: dict[str, Any]) -> dict[str, Any]:
    """Send a node an administrator's request; raises `aiohttp.ClientError`."""
    room = body.get("room", "")
    token = signed(KEY, "host", room=room, roomCreate=True, roomAdmin=True, roomList=True)
    path = f"/twirp/livekit.RoomService/{what}"
    headers = {"Authorization": f"Bearer {token}"}
    async with (
        aiohttp.ClientSession(raise_for_status=True) as http,
        http.post(url + path, json=body, headers=headers) as response,
    ):
        told: dict[str, Any] = await response.json()
    return told


@asynccontextmanager
async def running(log: TextIO | None = None) -> AsyncIterator[Engine]:
    engine = Engine(log)
    try:
        await engine.start()
        yield engine
    finally:
        await engine.stop()
