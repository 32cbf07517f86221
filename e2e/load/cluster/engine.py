"""Two nodes of LiveKit on one Redis, and a room pinned to each."""

from __future__ import annotations

import asyncio
import shutil
from contextlib import asynccontextmanager, contextmanager
from tempfile import TemporaryFile
from typing import TYPE_CHECKING, Any, Final, TextIO

import aiohttp
import jwt

from e2e.harness.missing import missing
from e2e.harness.server import free_port
from e2e.harness.wait import eventually
from e2e.measure.errors import NotRunError
from e2e.peers.livekit.errors import LiveKitError
from e2e.peers.livekit.installation import find_server
from e2e.peers.livekit.server import LiveKit, Ports
from e2e.peers.livekit.tokens import Key

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import AsyncIterator, Iterator

KEY: Final = Key("APItest", "s" * 32)
ROOMS: Final = ("robot-1", "robot-2")
_ADDRESS: Final = "127.0.0.1"
_SELECTOR: Final = {
    "kind": "regionaware",
    "sort_by": "rooms",
    "sysload_limit": 1_000_000,
    "regions": [{"name": room, "lat": 0, "lon": 90 * at} for at, room in enumerate(ROOMS)],
}
"""As config/deploy has it: a room that is made anew, too, lives on the node that was asked."""
_FOREVER_S: Final = 2**31


class Redis:
    """Brings the nodes together; it keeps nothing on a disk."""

    def __init__(self) -> None:
        self.port = free_port()
        self._process: Process | None = None

    async def start(self) -> None:
        self._process = await asyncio.create_subprocess_exec(
            *("redis-server", "--port", str(self.port), "--bind", _ADDRESS),
            *("--save", "", "--appendonly", "no"),
            stdout=asyncio.subprocess.DEVNULL,
        )
        await eventually(self._answers, "Redis answers")

    async def kill(self) -> None:
        """End it as a power cut does; safe to call twice."""
        if self._process is not None and self._process.returncode is None:
            self._process.kill()
            await self._process.wait()

    async def nodes(self) -> set[str]:
        """Return the ids of the nodes, which are drawn anew at each start."""
        return set((await self._ask("HKEYS", "nodes")).split())

    async def nodes_of_rooms(self) -> set[str]:
        """Return the ids of the nodes that have a room."""
        return set((await self._ask("HVALS", "room_node_map")).split())

    async def _answers(self) -> bool:
        return "PONG" in await self._ask("PING")

    async def _ask(self, *command: str) -> str:
        process = await asyncio.create_subprocess_exec(
            *("redis-cli", "-p", str(self.port), *command),
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.DEVNULL,
        )
        said, _ = await process.communicate()
        return said.decode()


class Engine:
    """The cluster; `nodes` in the order of `ROOMS`, each of which has its room."""

    def __init__(self, log: TextIO | None = None) -> None:
        self.redis = Redis()
        program = find_server()
        self.nodes = [
            LiveKit(
                program,
                _ADDRESS,
                Ports(free_port(), free_port(), free_port()),
                KEY,
                log=log,
                redis={"address": f"{_ADDRESS}:{self.redis.port}"},
                region=room,
                node_selector=_SELECTOR,
                rtc={"use_ice_lite": True},
            )
            for room in ROOMS
        ]

    async def start(self) -> None:
        await self.redis.start()
        for number in range(len(self.nodes)):
            await self._start_node(number)

    async def _start_node(self, number: int) -> None:
        """Start a node, and pin its room to it."""
        before = await self.redis.nodes()
        await self.nodes[number].start()

        async def is_known() -> bool:
            return len(await self.redis.nodes() - before) == 1

        await eventually(is_known, "Redis knows the node")
        (node,) = await self.redis.nodes() - before
        # With what the origin would ask for.
        room = {"name": ROOMS[number], "node_id": node, "empty_timeout": 600}
        room |= {"sync_streams": True, "max_playout_delay": 200}
        await call(self.nodes[number].url, "CreateRoom", room)

    async def stop(self) -> None:
        for node in self.nodes:
            await node.kill()
        await self.redis.kill()

    def url(self, number: int) -> str:
        """Return the address that pages use of this node."""
        return self.nodes[number].url.replace("http", "ws", 1)

    async def people(self, number: int) -> list[dict[str, Any]]:
        """Return who is in the room of this node, and what they publish."""
        told = await call(self.nodes[number].url, "ListParticipants", {"room": ROOMS[number]})
        people: list[dict[str, Any]] = told["participants"]
        return people


async def call(url: str, what: str, body: dict[str, Any]) -> dict[str, Any]:
    """Ask a node, as an administrator does; raises `aiohttp.ClientError`."""
    grants = {"room": body.get("room", ""), "roomCreate": True, "roomAdmin": True}
    claims = {"iss": KEY.name, "exp": _FOREVER_S, "video": {**grants, "roomList": True}}
    token = jwt.encode(claims, KEY.secret, algorithm="HS256")
    async with (
        aiohttp.ClientSession(raise_for_status=True) as http,
        http.post(
            f"{url}/twirp/livekit.RoomService/{what}",
            json=body,
            headers={"Authorization": f"Bearer {token}"},
        ) as response,
    ):
        told: dict[str, Any] = await response.json()
    return told


@contextmanager
def quiet_log() -> Iterator[TextIO]:
    """Have a log that nobody reads: the nodes tell of each subscriber who leaves."""
    with TemporaryFile("w", encoding="utf-8") as log:
        yield log


def installed(log: TextIO | None = None) -> Engine:
    """Return a cluster to start, whose nodes log to `log`; raises `NotRunError` without one."""
    if shutil.which("redis-server") is None:
        raise NotRunError("there is no Redis; install the package redis-server")
    try:
        return Engine(log)
    except LiveKitError as error:
        raise NotRunError(str(error)) from error


@asynccontextmanager
async def running() -> AsyncIterator[Engine]:
    """Run it for a test; skips where LiveKit or Redis is missing."""
    try:
        engine = installed()
    except NotRunError as error:
        missing(str(error))
    try:
        await engine.start()
        yield engine
    finally:
        await engine.stop()
