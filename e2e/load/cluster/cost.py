"""What an observer in a LiveKit room costs its node, and the robot's own server.

``python -m e2e.load.cluster.cost URL`` is `OBSERVERS` viewers in a room until its standard input
ends; each gets the best picture and the sound.
"""

from __future__ import annotations

import asyncio
import os
import sys
import time
import uuid
from typing import TYPE_CHECKING, Final

import aiohttp
from livekit import rtc

from e2e.harness.child import child
from e2e.load.cluster.engine import KEY, ROOMS
from e2e.load.cluster.stage import staged
from e2e.load.process import ProcessMeter
from e2e.measure.row import Row, middle, summarize
from e2e.peers.livekit.tokens import signed

if TYPE_CHECKING:
    from collections.abc import Sequence

OBSERVERS: Final = 16
"""More do not fit on their core, since LiveKit's SDK decodes what it receives."""
RENEW_S: Final = 240.0
"""How often the page renews its seat, the only cost of an observer for the robot's server."""
_PAGES: Final = 200
_AT_ONCE: Final = 4
_CPU_PERCENT: Final = 0.005
_SETTLE_S: Final = 4.0
_WINDOW_S: Final = 8.0
_ENTER_S: Final = 30.0
_LEAVE_S: Final = 10.0
_NICENESS: Final = 10
"""Decoding here must not delay whoever publishes on this core."""


async def room_cost(n: int) -> list[Row]:
    """Measure `n` pairs of windows, without and with `OBSERVERS` in the room; and seat renewals."""
    cpu, robots_cpu = [], []
    async with staged("engine") as stage:
        nodes = [ProcessMeter(node.pid) for node in stage.engine.nodes]
        server = ProcessMeter(stage.server.pid)
        for _ in range(n):
            none = await _window(nodes)
            # LiveKit sends to a vanished observer for a while.
            observers = child("e2e.load.cluster.cost", stage.engine.url(0), leaves_s=_LEAVE_S)
            async with observers as entered:
                await entered.line(_ENTER_S)
                many = await _window(nodes)
            cpu.append((many - none) / OBSERVERS * 100)
            robots_cpu.append(await _renewal_s(stage.server.url, server) / RENEW_S * 100)

    what = "what an observer in a room costs the robot's own server"
    row = middle("room: server cpu", what, "% of a core", robots_cpu, _CPU_PERCENT, n=n)
    return [row.model_copy(update={"detail": {"LiveKit's node": summarize(cpu).median}})]


async def _window(nodes: Sequence[ProcessMeter]) -> float:
    """Return the nodes' processor time per second of each."""
    await asyncio.sleep(_SETTLE_S)
    return sum(await asyncio.gather(*(one.share(_WINDOW_S) for one in nodes)))


async def _renewal_s(url: str, server: ProcessMeter) -> float:
    """Return the processor time of one renewal, in addition to the server's usual."""
    gate = asyncio.Semaphore(_AT_ONCE)

    async def renew(http: aiohttp.ClientSession, tab: str) -> None:
        async with gate, http.post(f"{url}/api/seat", json={"client": tab}) as answer:
            await answer.read()

    idle = await server.share(_WINDOW_S)
    sessions = [
        aiohttp.ClientSession(
            cookie_jar=aiohttp.CookieJar(unsafe=True),  # the server is an address
            headers={"Origin": url, "Connection": "close"},  # it would be closed before the next
            raise_for_status=True,
        )
        for _ in range(_PAGES)
    ]
    pages = [(http, str(uuid.uuid4())) for http in sessions]
    try:
        await asyncio.gather(*(renew(*page) for page in pages))  # until they have their seats
        cpu_s, began_s = server.cpu_s(), time.monotonic()
        await asyncio.gather(*(renew(*page) for page in pages))
        return (server.cpu_s() - cpu_s - idle * (time.monotonic() - began_s)) / _PAGES
    finally:
        await asyncio.gather(*(http.close() for http in sessions))


async def _observe(url: str) -> None:
    rooms = [await _entered(url, f"observer {number}") for number in range(OBSERVERS)]
    print(len(rooms), flush=True)
    await asyncio.to_thread(sys.stdin.read)
    await asyncio.gather(*(room.disconnect() for room in rooms))


async def _entered(url: str, name: str) -> rtc.Room:
    token = signed(KEY, name, room=ROOMS[0], roomJoin=True, canPublish=False, hidden=True)
    room = rtc.Room()
    await room.connect(url, token, rtc.RoomOptions(auto_subscribe=False))
    for robot in room.remote_participants.values():
        for track in robot.track_publications.values():
            if track.kind == rtc.TrackKind.KIND_AUDIO or "640x480" in robot.identity:
                track.set_subscribed(True)
    return room


if __name__ == "__main__":
    os.nice(_NICENESS)
    asyncio.run(_observe(sys.argv[1]))
