"""An operator without a browser: drives over WebRTC as a page does, and does as it is told.

A process of its own (`python -m wax.proof.operator URL`), so that it can be frozen whole, as a
network vanishes: no command, no heartbeat and no acknowledgement leaves it. A word a line on its
standard input says what to do; a line of JSON on its standard output tells its `Seat` when that
changes. It ends with its input. It must run on the server's machine: both read one clock.
"""

from __future__ import annotations

import asyncio
import json
import sys
import time
import uuid
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, Final, Literal

import aiohttp
from aiortc import RTCConfiguration, RTCPeerConnection, RTCSessionDescription
from pydantic import TypeAdapter

from wax import messages, rows

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

Order = Literal["join", "leave", "neutral", "drive", "stop", "stop by http", "release"]
ORDERS: TypeAdapter[Order] = TypeAdapter(Order)

_COMMAND_S: Final = 0.02
_PING_EVERY: Final = 10
"""Commands; five heartbeats a second."""
_CONNECT_S: Final = 15.0
_HTTP_S: Final = 5.0


@dataclass(frozen=True, slots=True)
class Seat:
    """What the server has told: whose turn it is, which stop is latched, what is in the way."""

    is_open: bool = False
    drives: bool = False
    stop: int | None = None
    reason: str | None = None


class Operator:
    """One peer from `connect` to `close`; `tell` gets each new `Seat`."""

    def __init__(self, url: str, tell: Callable[[Seat], None]) -> None:
        self._url = url
        self._tell = tell
        self._client = str(uuid.uuid4())
        self._peer = RTCPeerConnection(RTCConfiguration(iceServers=[]))
        self._state = self._peer.createDataChannel("state")
        self._drive = self._peer.createDataChannel("drive", ordered=False, maxRetransmits=0)
        self._http = aiohttp.ClientSession(timeout=aiohttp.ClientTimeout(total=_HTTP_S))
        self._seat = Seat()
        self._viewer: int | None = None
        self._turn = 0
        self._seq = 0
        self._ahead = 0.0
        self._pings = 0
        self._pong: tuple[int, float] | None = None
        self._requests: set[asyncio.Task[None]] = set()
        self._opened = asyncio.Event()
        self._state.on("open", self._channel_opened)
        self._drive.on("open", self._channel_opened)
        self._state.on("message", self._heard)
        self._drive.on("message", self._heard_pong)

    async def connect(self) -> None:
        """Open both channels; raises `TimeoutError` or `aiohttp.ClientError`."""
        for kind in ("audio", "video"):
            self._peer.addTransceiver(kind, direction="recvonly")
        await self._peer.setLocalDescription(await self._peer.createOffer())
        offer = {"sdp": self._peer.localDescription.sdp, "client": self._client}
        async with self._http.post(f"{self._url}/api/offer", json=offer) as response:
            response.raise_for_status()
            answer = await response.json()
        await self._peer.setRemoteDescription(RTCSessionDescription(answer["sdp"], "answer"))
        async with asyncio.timeout(_CONNECT_S):
            await self._opened.wait()
        self._say(messages.SetName(type="name", name="Proof of the stop"))
        self._become(replace(self._seat, is_open=True))

    async def run(self) -> None:
        """Send commands and heartbeats until cancelled; one that is late is not made up for."""
        due_s = time.monotonic()
        while self._drive.readyState == "open":
            self._command()
            if self._seq % _PING_EVERY == 0:
                self._ping()
            due_s = max(due_s + _COMMAND_S, time.monotonic())
            await asyncio.sleep(due_s - time.monotonic())

    async def close(self) -> None:
        await asyncio.gather(*self._requests, return_exceptions=True)
        await self._http.close()
        await self._peer.close()

    def obey(self, order: Order) -> None:
        """Do what the proof says; driving goes on through every stop, as a mean operator would."""
        match order:
            case "join":
                self._say(messages.Join(type="join"))
            case "leave":
                self._say(messages.Leave(type="leave"))
            case "neutral":
                self._ahead = 0.0
            case "drive":
                self._ahead = 1.0
            case "stop":
                self._say(messages.Stop(type="stop"))
            case "stop by http":
                request = asyncio.create_task(self._stop_by_http(), name="stop by HTTP")
                self._requests.add(request)
                request.add_done_callback(self._requests.discard)
            case "release":
                if self._seat.stop is not None:
                    self._say(
                        messages.Release(
                            type="release", stop=self._seat.stop, sent_server_ms=_now_ms()
                        )
                    )

    async def _stop_by_http(self) -> None:
        async with self._http.post(
            f"{self._url}/api/stop", json={"client": self._client}
        ) as response:
            response.raise_for_status()

    def _command(self) -> None:
        self._seq += 1
        command = messages.Drive(
            type="drive",
            seq=self._seq,
            turn=self._turn,
            sent_server_ms=_now_ms(),
            linear=self._ahead,
            angular=0.0,
            held=self._ahead != 0.0,
            speed="fine",
            seen_server_ms=None,
        )
        self._drive.send(rows.write(command))

    def _ping(self) -> None:
        self._pings += 1
        now_ms = _now_ms()
        number, came_ms = self._pong or (None, None)
        ping = messages.Ping(
            type="ping",
            id=self._pings,
            sent_page_ms=now_ms,
            pong_id=number,
            pong_held_ms=None if came_ms is None else now_ms - came_ms,
        )
        self._drive.send(rows.write(ping))

    def _channel_opened(self) -> None:
        if self._state.readyState == self._drive.readyState == "open":
            self._opened.set()

    def _heard_pong(self, data: str | bytes) -> None:
        named = rows.read(data, messages.DRIVE_COLUMNS)
        self._pong = named["id"], _now_ms()

    def _heard(self, data: str | bytes) -> None:
        heard: dict[str, Any] = json.loads(data)
        match heard["type"]:
            case "hello":
                self._viewer = heard["viewer"]
            case "drive_status":
                self._become(replace(self._seat, reason=heard["reason"]))
            case "room":
                drives = heard["turn"]["operator"] == self._viewer
                if drives:
                    self._turn = heard["turn"]["number"]
                stop = None if heard["stop"] is None else heard["stop"]["number"]
                self._become(replace(self._seat, drives=drives, stop=stop))

    def _say(self, message: messages.StateIn) -> None:
        self._state.send(message.model_dump_json())

    def _become(self, seat: Seat) -> None:
        if seat != self._seat:
            self._seat = seat
            self._tell(seat)


def _now_ms() -> float:
    return time.monotonic() * 1000.0


async def _obey(operator: Operator, orders: asyncio.StreamReader) -> None:
    async for line in orders:
        operator.obey(ORDERS.validate_python(line.decode().strip()))


async def _first(*works: Coroutine[Any, Any, None]) -> None:
    """Run all until the first one ends: the link is lost, or nobody gives orders any more."""
    tasks = [asyncio.create_task(work) for work in works]
    await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)


async def _main(url: str) -> None:
    loop = asyncio.get_running_loop()
    orders = asyncio.StreamReader()
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(orders), sys.stdin)

    def tell(seat: Seat) -> None:
        sys.stdout.write(json.dumps(asdict(seat)) + "\n")
        sys.stdout.flush()

    operator = Operator(url, tell)
    try:
        await operator.connect()
        await _first(operator.run(), _obey(operator, orders))
    finally:
        await operator.close()


if __name__ == "__main__":
    asyncio.run(_main(sys.argv[1]))
