"""All rooms together: removals, news, and failures that stay contained."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any, cast

import jwt
import pytest
from aiohttp import web
from tests.turned_clock import TurnedClock
from tests.until import async_until

from wax.cluster import cluster as cluster_module
from wax.cluster.cluster import Cluster, PublishedSources
from wax.config.publish import PublishSettings
from wax.telemetry import Counters

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from wax.fanout.sound_hub import SoundHub
    from wax.fanout.video_hub import VideoHub
    from wax.streams.interface import Codecs

SECRET = "s" * 32


class LiveKit:
    """A media server that records requests and refuses to be published to, but at `moved_to`."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, dict[str, Any]]] = []
        self.url = self.moved_to = ""

    async def handle(self, request: web.Request) -> web.Response:
        jwt.decode(
            request.headers["Authorization"].removeprefix("Bearer "),
            SECRET,
            algorithms=["HS256"],
            options={"verify_exp": False, "verify_nbf": False},
        )
        if self.moved_to and request.raw_path != self.moved_to:
            return web.Response(status=307, headers={"Location": self.moved_to})
        if request.path.startswith("/whip"):
            return web.Response(status=503)
        what = request.path.rpartition("/")[2]
        self.asked.append((what, await request.json()))
        return web.json_response({"rooms": [{"num_participants": 9}]})

    def of(self, what: str) -> list[dict[str, Any]]:
        return [body for asked, body in self.asked if asked == what]


@pytest.fixture
async def livekit() -> AsyncIterator[LiveKit]:
    made = LiveKit()
    application = web.Application()
    application.router.add_route("POST", "/{path:.*}", made.handle)
    runner = web.AppRunner(application)
    await runner.setup()
    await web.TCPSite(runner, "127.0.0.1", 0).start()
    made.url = f"ws://127.0.0.1:{runner.addresses[0][1]}"
    yield made
    await runner.cleanup()


@pytest.fixture
async def rig(
    livekit: LiveKit, monkeypatch: pytest.MonkeyPatch
) -> AsyncIterator[tuple[Cluster, TurnedClock]]:
    """Return a cluster of two rooms without renditions, so that nothing is published."""
    monkeypatch.setattr(cluster_module, "_BROADCAST_S", 0.02)
    monkeypatch.setattr(cluster_module, "_POLL_S", 0.01)
    clock = TurnedClock()
    made = Cluster(clock=clock, counters=Counters())
    rooms = [
        PublishSettings(livekit=livekit.url, room=room, api_key="APIkey", api_secret=SECRET)
        for room in ("a", "b")
    ]
    nothing = cast("Codecs", None), cast("VideoHub", None), cast("SoundHub", None)
    made.publish(rooms, [], PublishedSources(*nothing))
    running = asyncio.create_task(made.run())
    await async_until(lambda: len(livekit.of("ListRooms")) == 2)
    yield made, clock
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)


def names(livekit: LiveKit) -> list[str]:
    return [body["identity"] for body in livekit.of("RemoveParticipant")]


async def test_who_is_out_for_good_is_removed_again(
    livekit: LiveKit, rig: tuple[Cluster, TurnedClock]
) -> None:
    """A person is removed from every room once, or, for good, until their token has expired."""
    cluster, clock = rig
    cluster.remove("p-gone")
    cluster.remove("p-banned", for_good=True)
    await async_until(lambda: len(names(livekit)) == 4)
    assert {body["room"] for body in livekit.of("RemoveParticipant")} == {"a", "b"}
    clock.time_s += 6
    await async_until(lambda: len(names(livekit)) == 6)
    assert names(livekit)[4:] == ["p-banned"] * 2
    assert cluster.seats("p-banned")
    clock.time_s += 1000
    cluster.remove("p-other")
    await async_until(lambda: "p-other" in names(livekit))
    assert names(livekit).count("p-banned") == 4, "they have a seat again"


async def test_all_are_told_while_there_is_something_to_tell(
    livekit: LiveKit, rig: tuple[Cluster, TurnedClock]
) -> None:
    """News is sent to each room; an exception in `news` stops nothing else."""
    cluster, _ = rig
    assert livekit.of("SendData") == []

    def broken() -> str | None:
        raise ZeroDivisionError

    cluster.broadcast(broken)
    await async_until(lambda: cluster._counters.snapshot().get("room messages failed", 0) >= 2)
    assert cluster._counters.snapshot().get("cluster faults", 0) == 0
    cluster.broadcast(lambda: "news")
    await async_until(lambda: len(livekit.of("SendData")) >= 4)
    assert {body["room"] for body in livekit.of("SendData")} == {"a", "b"}
    await async_until(lambda: cluster.watching == 18)
    assert [one["is_live"] for one in cluster.status()] == [True, True]


async def test_a_redirect_is_followed_as_it_is_written(
    livekit: LiveKit, rig: tuple[Cluster, TurnedClock]
) -> None:
    """A redirect's address is used byte for byte: it may be signed."""
    cluster, _ = rig
    livekit.moved_to = "/rooms%2F1/SendData?sig=A%2Fd%2Be%3D"
    cluster.broadcast(lambda: "news")
    await async_until(lambda: bool(livekit.of("SendData")))


async def test_without_rooms_there_is_nothing() -> None:
    """A cluster without rooms has no seats and no status, and connects to nothing."""
    cluster = Cluster(clock=TurnedClock(), counters=Counters())
    assert (cluster.seats("p-1"), cluster.links, cluster.status()) == ([], [], [])
    assert not cluster.is_used
    running = asyncio.create_task(cluster.run())
    await asyncio.sleep(0)
    assert not running.done()
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)


async def test_a_fault_of_the_rooms_is_contained(
    monkeypatch: pytest.MonkeyPatch, livekit: LiveKit
) -> None:
    """A failure is counted and the rooms restart; `run` never ends by itself."""
    monkeypatch.setattr(cluster_module, "_RETRY_S", 0.01)
    counters = Counters()
    cluster = Cluster(clock=TurnedClock(), counters=counters)
    settings = PublishSettings(livekit=livekit.url, api_key="APIkey", api_secret=SECRET)
    nothing = cast("Codecs", None), cast("VideoHub", None), None
    cluster.publish([settings], [], PublishedSources(*nothing))

    async def broken(*_: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(cluster, "_count", broken)
    running = asyncio.create_task(cluster.run())
    await async_until(lambda: counters.snapshot().get("cluster faults", 0) >= 2)
    assert not running.done()
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)
