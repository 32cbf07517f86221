"""The server and a real cluster: what is published, who may watch, and what happens without it."""

from __future__ import annotations

import asyncio
import os
import re
from contextlib import asynccontextmanager
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import pytest
import tomlkit
from tests.free_port import free_port

from e2e.harness import toml
from e2e.harness.wait import answers, eventually, until
from e2e.load.cluster.engine import KEY, ROOMS, Redis, call, running
from e2e.load.cluster.stage import are_live, published
from e2e.load.cluster.watcher import watching
from e2e.measure.suite import ROOT
from e2e.peers.livekit.installation import find_server
from e2e.peers.livekit.tokens import signed
from wax.client.client import Client
from wax.client.operator import Operator
from wax.errors import SignallingError

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import AsyncIterator
    from pathlib import Path

    from e2e.conftest import Serve
    from e2e.harness.server import Server

pytestmark = pytest.mark.timeout(120)

NOTICED_S = 4.0
BACK_S = 5.0
ENGINES_OWN_S = 5.0
"""LiveKit reassigns a dead node's rooms only after this."""


@asynccontextmanager
async def person(server: Server) -> AsyncIterator[Client]:
    """Have a browser that talks to the server by HTTP only."""
    client = Client(server.url)
    try:
        yield client
    finally:
        await client.close()


@asynccontextmanager
async def driving(server: Server) -> AsyncIterator[list[bool]]:
    """Drive inside the block; yield a list that gets whether the robot moved, at each change."""
    moved: list[bool] = []

    def heard(message: dict[str, Any]) -> None:
        if message["type"] == "drive_status":
            moved.append(message["moving"])

    async with Operator(server.url, sees=True, on_message=heard) as operator:
        await operator.join()
        operator.let_go()
        await asyncio.sleep(0.1)
        operator.steer(0.0, 1.0)  # on the spot, where there is no wall
        assert await operator.until(lambda: moved[-1:] == [True]), "the robot moves"
        moved.clear()
        yield moved
        assert operator.has_turn
        assert await operator.pongs()


async def answered(client: Client) -> Any:
    """Return the answer to an offer such as a page makes."""
    await client.peer.setLocalDescription(await client.peer.createOffer())
    return await client.post("/api/offer", {"sdp": client.peer.localDescription.sdp})


async def test_a_room_has_both_renditions_and_the_sound(serve: Serve, tmp_path: Path) -> None:
    """A viewer with a seat sees and hears, unseen by others, and gets the robot's news."""
    async with published(serve, tmp_path) as (_, server), person(server) as ada:
        seats = (await ada.post("/api/seat", {}))["rooms"]
        assert len(seats) == 2
        for seat in seats:
            async with watching(seat) as watcher:
                await watcher.watches()
                sizes = {max(sizes) for sizes in watcher.pictures.values()}
                assert sizes == {(640, 480), (320, 240)}
                told = watcher.told[-1]
                assert (told["type"], told["room"]["turn"]["operator"]) == ("told", None)
                assert sorted(watcher.mime_types) == ["audio/opus", "video/VP8", "video/VP8"]


async def test_a_full_server_sends_observers_elsewhere(serve: Serve, tmp_path: Path) -> None:
    """Beyond its places a page is offered seats; without a cluster it reads that all is full."""
    async with published(serve, tmp_path) as (engine, server), Client(server.url):
        async with person(server) as ada:
            answer = await answered(ada)
            assert (answer["type"], len(answer["rooms"])) == ("sent_to_room", 2)
            assert answer["hello"]["viewer"] == 0
        await engine.stop()
        await are_live(server, 0, within_s=10)
        async with person(server) as bob:
            with pytest.raises(SignallingError, match=r"503 .*All places to watch are taken"):
                await answered(bob)


async def test_a_killed_node_is_noticed_and_used_again(serve: Serve, tmp_path: Path) -> None:
    """The other room and driving continue, and the node is published to again when it is back."""
    async with (
        published(serve, tmp_path) as (engine, server),
        driving(server) as moved,
        person(server) as ada,
    ):
        seats = (await ada.post("/api/seat", {}))["rooms"]
        (other,) = [one for one in seats if one["url"] == engine.url(1)]
        async with watching(other) as watcher:
            await watcher.watches()
            await engine.nodes[0].kill()
            await are_live(server, 1, NOTICED_S)
            watcher.pictures.clear()
            await watcher.watches()
            await asyncio.sleep(ENGINES_OWN_S)
            await engine.nodes[0].start()
            await are_live(server, 2, within_s=BACK_S)
            assert not watcher.is_out
        assert moved == []


async def test_a_node_that_hung_keeps_its_room(serve: Serve, tmp_path: Path) -> None:
    """By then LiveKit counts it as dead, and would give its room to the other node for good."""
    async with published(serve, tmp_path) as (engine, server):
        engine.nodes[1].freeze()
        await are_live(server, 1, NOTICED_S)
        await asyncio.sleep(ENGINES_OWN_S)
        engine.nodes[1].thaw()
        await are_live(server, 2, within_s=15)
        assert len(await engine.redis.nodes_of_rooms()) == 2


async def test_without_redis_and_without_the_cluster_driving_goes_on(
    serve: Serve, tmp_path: Path
) -> None:
    """Neither the loss of Redis nor that of all nodes stops the robot or the server."""
    async with published(serve, tmp_path) as (engine, server), driving(server) as moved:
        await engine.redis.kill()
        await asyncio.sleep(NOTICED_S)
        assert await server.status()
        for node in engine.nodes:
            await node.kill()
        await are_live(server, 0, NOTICED_S)
        assert moved == []


async def test_the_hosts_acts_reach_the_rooms(serve: Serve, tmp_path: Path) -> None:
    """Whoever waits elsewhere and is banned is removed from the room, and gets no seat again."""
    async with (
        published(serve, tmp_path) as (_, server),
        Client(server.url, cookies=await server.host_cookies()) as host,
        person(server) as eve,
        person(server) as ada,
    ):
        mine = (await eve.post("/api/seat", {}))["rooms"][0]
        others = (await ada.post("/api/seat", {}))["rooms"][0]
        async with watching(mine) as watcher, watching(others) as innocent:
            line = await eve.post("/api/queue", {"wants": "join"})
            host.send(type="remove", viewer=line["id"], ban=True)
            await watcher.leaves()
            for path, body in {"/api/seat": {}, "/api/queue": {"wants": "join"}}.items():
                with pytest.raises(SignallingError, match=r"403 .*asked you to leave"):
                    await eve.post(path, body)
            assert not innocent.is_out
            host.send(type="close", closed=True)
            await innocent.leaves()
            with pytest.raises(SignallingError, match=r"403 .*closed"):
                await ada.post("/api/seat", {})


async def test_who_watches_elsewhere_stops_the_robot(serve: Serve, tmp_path: Path) -> None:
    """Everybody who watches may stop it, within their budget; without a seat nobody may."""
    async with published(serve, tmp_path) as (_, server), driving(server) as moved:
        async with person(server) as ada:
            with pytest.raises(SignallingError, match="403"):
                await ada.post("/api/stop", {})
            await ada.post("/api/seat", {})
            await ada.post("/api/stop", {})
            await until(lambda: moved[-1:] == [False], "the robot stands")
        assert (await server.status())["stop"]["by"] == "somebody who watches elsewhere"


async def test_any_whip_server_gets_the_best_picture_and_the_sound(
    serve: Serve, tmp_path: Path
) -> None:
    """LiveKit stands for any WHIP server; pages get a link to where the robot can be watched."""
    async with running() as engine:
        table = {
            "whip": f"{engine.nodes[0].url}/whip/v1",
            "whip_token": signed(KEY, "whip", room=ROOMS[0], roomJoin=True, canPublish=True),
            "watch": "https://media.example.org/robot",
        }
        toml_text = f"{toml.card_with(server='max_viewers = 1')}[[publish]]\n{tomlkit.dumps(table)}"
        async with serve(tmp_path, toml_text) as server, person(server) as ada:
            await are_live(server, 1, within_s=10)

            async def publishes() -> bool:
                (robot,) = await engine.people(0)
                return sorted(one["type"] for one in robot["tracks"]) == ["AUDIO", "VIDEO"]

            await eventually(publishes, "picture and sound are there")
            told = await ada.post("/api/seat", {})
            assert (told["rooms"], told["links"]) == ([], [table["watch"]])
        assert await engine.people(0) == [], "it has said goodbye"


# --- config/deploy's files for the cluster, tried with the real programs ---------------------

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
    """LiveKit accepts the file and the arguments; a room lives on the node that it was asked of."""
    program = find_server()
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
