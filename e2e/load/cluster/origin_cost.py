"""What an observer at the cluster costs the robot's own server: requests, and the rooms' news."""

from __future__ import annotations

import asyncio
import random
import time
import uuid
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from heapq import heapify, heapreplace
from typing import TYPE_CHECKING, Final

import aiohttp

from e2e.harness.wait import eventually
from e2e.load.cluster.engine import KEY, ROOMS, installed, quiet_log
from e2e.load.cluster.published import are_live
from e2e.load.cluster.wire import Wire, counted
from e2e.load.process import pinned, two_cores
from e2e.load.servers import WAX, serving
from e2e.measure.errors import MeasureError, NotRunError
from e2e.measure.row import Row, summed
from wax.client import Operator

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Sequence

    from e2e.load.cluster.engine import Engine
    from e2e.load.servers import MeasuredServer

OBSERVERS: Final = 1000
QUEUED: Final = 10
"""Of the observers, who wait for a turn."""
_CPU_PERCENT: Final = 0.005
_BYTES: Final = 50.0
_WINDOW_S: Final = 10.0
_SETTLE_S: Final = 5.0
_RENEW_S: Final = 240.0
_STAY_S: Final = 5.0
"""As the page does both."""
_PRESS_S: Final = 0.1
_AT_ONCE: Final = 4
_AS_BROWSER: Final = {
    "Accept": "*/*",
    "Accept-Encoding": "gzip, deflate, br, zstd",
    "Accept-Language": "en-GB,en-US;q=0.9,en;q=0.8",
    "Sec-Fetch-Dest": "empty",
    "Sec-Fetch-Mode": "cors",
    "Sec-Fetch-Site": "same-origin",
    "User-Agent": "Mozilla/5.0 (Windows NT 10.0; Win64; x64) AppleWebKit/537.36 (KHTML, like"
    " Gecko) Chrome/142.0.0.0 Safari/537.36",
    "sec-ch-ua": '"Chromium";v="142", "Google Chrome";v="142", "Not_A Brand";v="99"',
    "sec-ch-ua-mobile": "?0",
    "sec-ch-ua-platform": '"Windows"',
}
"""What Chromium says with each `fetch`."""


@dataclass(frozen=True, slots=True)
class Costs:
    """Of one window: seconds of processor time, and bytes on the wire, both ways, a second."""

    cpu: float
    requests_bytes: float
    news_bytes: float


class Page:
    """One tab that watches elsewhere, as far as the robot's server notices it."""

    def __init__(self, url: str, wire: Wire) -> None:
        self._url = url
        self._body = {"client": str(uuid.uuid4())}
        self._http = aiohttp.ClientSession(
            cookie_jar=aiohttp.CookieJar(unsafe=True),  # the server is an address
            connector=aiohttp.TCPConnector(keepalive_timeout=3600, socket_factory=wire.connecting),
            headers={**_AS_BROWSER, "Origin": url, "Referer": f"{url}/"},
            raise_for_status=True,
        )

    async def renew(self) -> None:
        """Get a seat, or keep it. The server would close the connection long before the next."""
        await self._post("/api/seat", "close")

    async def queue(self, wants: str) -> None:
        await self._post("/api/queue", "keep-alive", wants=wants)

    async def close(self) -> None:
        await self._http.close()

    async def _post(self, path: str, connection: str, **more: str) -> None:
        headers = {"Connection": connection}
        body = self._body | more
        async with self._http.post(self._url + path, json=body, headers=headers) as answer:
            await answer.read()


class Crowd:
    """Asks what all its pages ask, spread over time; between two windows its time stands still."""

    def __init__(self, pages: Sequence[Page]) -> None:
        self._pages = pages
        self._now_s = 0.0
        self._due: list[tuple[float, int, bool]] = [
            (random.uniform(0, _RENEW_S), number, False) for number in range(len(pages))
        ] + [(random.uniform(0, _STAY_S), number, True) for number in range(QUEUED)]
        heapify(self._due)

    async def enter(self) -> None:
        """Get all their seats, and places in the queue; raises `aiohttp.ClientError`."""
        for start in range(0, len(self._pages), _AT_ONCE):
            await asyncio.gather(*(one.renew() for one in self._pages[start : start + _AT_ONCE]))
        await asyncio.gather(*(one.queue("join") for one in self._pages[:QUEUED]))

    async def ask(self) -> None:
        """Ask for the length of a window; raises `aiohttp.ClientError`."""
        begun_s, ends_s = time.monotonic() - self._now_s, self._now_s + _WINDOW_S
        async with asyncio.TaskGroup() as asking:
            while (first := self._due[0])[0] < ends_s:
                at_s, number, queues = first
                await asyncio.sleep(at_s - (time.monotonic() - begun_s))
                page = self._pages[number]
                asking.create_task(page.queue("stay") if queues else page.renew())
                again_s = _STAY_S if queues else _RENEW_S * random.uniform(0.9, 1.1)
                heapreplace(self._due, (at_s + again_s, number, queues))
        self._now_s = ends_s
        await asyncio.sleep(ends_s - (time.monotonic() - begun_s))


async def origin_cost(n: int) -> list[Row]:
    """Measure `n` pairs of windows in which nobody asks and all do; the server on its own core.

    The news for the rooms goes on in both, as it costs the same however many watch; of its bytes
    each observer bears a share. Raises `NotRunError`.
    """
    cores = two_cores()
    if cores is None:
        raise NotRunError("this needs two cores and a way to pin processes to them (Linux)")
    server_core, others_core = cores
    requests, news = Wire(), Wire()
    async with AsyncExitStack() as leaving:
        leaving.enter_context(pinned(others_core))
        engine = installed(leaving.enter_context(quiet_log()))
        leaving.push_async_callback(engine.stop)
        await engine.start()
        server = await leaving.enter_async_context(_published(engine, server_core, news))
        operator = await leaving.enter_async_context(Operator(server.url))
        await operator.join()
        operator.let_go()
        await asyncio.sleep(_PRESS_S)
        operator.steer(0.0, 1.0)
        await asyncio.sleep(_SETTLE_S)
        pages = [Page(server.url, requests) for _ in range(OBSERVERS)]
        for page in pages:
            leaving.push_async_callback(page.close)
        before = await _window(server, requests, news, asyncio.sleep(_WINDOW_S))
        crowd = Crowd(pages)
        await crowd.enter()
        await asyncio.sleep(_SETTLE_S)
        pairs = [
            (
                await _window(server, requests, news, asyncio.sleep(_WINDOW_S)),
                await _window(server, requests, news, crowd.ask()),
            )
            for _ in range(n)
        ]
        if not operator.has_turn:
            raise MeasureError("the operator has lost their turn")
    cpu = [(many.cpu - none.cpu) / OBSERVERS * 100 for none, many in pairs]
    wire = [
        (many.requests_bytes + many.news_bytes - before.news_bytes) / OBSERVERS for _, many in pairs
    ]
    rows = [
        summed(
            "origin: cpu",
            "what an observer at the cluster costs the robot's server",
            "% of a core",
            cpu,
            _CPU_PERCENT,
            judged="median",
            pairs=[str(pair) for pair in pairs],
        ),
        summed(
            "origin: bytes",
            "… on its wire, both ways, all headers",
            "B/s",
            wire,
            _BYTES,
            judged="median",
        ),
    ]
    load = f"{OBSERVERS} observers, {QUEUED} of them in the queue"
    return [row.model_copy(update={"load": load}) for row in rows]


@asynccontextmanager
async def _published(engine: Engine, core: int, news: Wire) -> AsyncIterator[MeasuredServer]:
    """Serve, with one place; what it asks the engine for is counted."""
    async with AsyncExitStack() as leaving:
        rooms = []
        for node, room in zip(engine.nodes, ROOMS, strict=True):
            port = int(node.url.rpartition(":")[2])
            passed = await leaving.enter_async_context(counted(news, port))
            url = f"ws://127.0.0.1:{passed}"
            key = {"api_key": KEY.name, "api_secret": KEY.secret}
            rooms.append({"livekit": url, "room": room, "max_viewers": OBSERVERS, **key})
        server = await leaving.enter_async_context(
            serving(WAX, core, publish=rooms, server={"max_viewers": 1})
        )
        await eventually(lambda: are_live(server, 2), "both rooms are published to", within_s=20)
        yield server


async def _window(
    server: MeasuredServer, requests: Wire, news: Wire, meanwhile: Awaitable[None]
) -> Costs:
    begun_s, cpu_s = time.monotonic(), server.meter.cpu_s()
    before = requests.bytes(), news.bytes()
    await meanwhile
    lasted_s = time.monotonic() - begun_s
    return Costs(
        (server.meter.cpu_s() - cpu_s) / lasted_s,
        (requests.bytes() - before[0]) / lasted_s,
        (news.bytes() - before[1]) / lasted_s,
    )
