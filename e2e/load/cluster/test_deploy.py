"""What config/deploy has of the cluster, taken by the programs themselves."""

from __future__ import annotations

import asyncio
import os
import re
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Final

import aiohttp

from e2e.harness.missing import missing
from e2e.harness.server import free_port
from e2e.harness.wait import eventually
from e2e.load.cluster.engine import KEY, ROOMS, Redis, call
from e2e.measure.suite import ROOT
from e2e.peers.livekit.errors import LiveKitError
from e2e.peers.livekit.installation import find_server

if TYPE_CHECKING:
    from asyncio.subprocess import Process

FOLDER: Final = ROOT / "config/deploy"
_NODES: Final = re.compile(r"command: (--config .*)")
_PORT: Final = re.compile(r"\b78[89]\d\b")


def command_lines() -> list[str]:
    """Return the nodes' arguments as compose.yaml has them, on ports that are free here."""
    lines = _NODES.findall((FOLDER / "compose.yaml").read_text(encoding="utf-8"))
    ports = {port: str(free_port()) for line in lines for port in _PORT.findall(line)}
    assert len(ports) == 3 * len(lines), "each node has its own"
    return [_PORT.sub(lambda found: ports[found.group()], line) for line in lines]


async def test_two_nodes_share_the_rooms() -> None:
    """LiveKit takes the file and the arguments; a room lives on the node that was asked for it."""
    try:
        program = find_server()
    except LiveKitError as error:
        missing(str(error))
    redis = Redis()
    nodes: list[Process] = []
    secrets = {"LIVEKIT_KEYS": f"{KEY.name}: {KEY.secret}", "NODE_IP": "127.0.0.1"}
    environment = {**os.environ, "REDIS_HOST": f"127.0.0.1:{redis.port}", **secrets}
    try:
        await redis.start()
        urls = []
        for line in command_lines():
            arguments = line.replace("/etc/", f"{FOLDER}/").split()
            nodes.append(await asyncio.create_subprocess_exec(program, *arguments, env=environment))
            urls.append(f"http://127.0.0.1:{arguments[arguments.index('--port') + 1]}")
            await eventually(partial(answers, urls[-1]), "the node answers", within_s=30)
        for url, room in zip(urls, ROOMS, strict=True):
            await call(url, "CreateRoom", {"name": room})
        assert len(await redis.nodes()) == len(nodes) == 2
        assert await redis.nodes_of_rooms() == await redis.nodes()
    finally:
        for node in nodes:
            node.kill()
            await node.wait()
        await redis.kill()


async def answers(url: str) -> bool:
    with suppress(aiohttp.ClientError):
        return "rooms" in await call(url, "ListRooms", {})
    return False
