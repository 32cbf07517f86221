"""One viewer without a screen: the page's side of the protocol, media counted and not decoded."""

from __future__ import annotations

import asyncio
import json
import random
import time
import uuid
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Literal

from aiortc import RTCConfiguration, RTCPeerConnection, RTCSessionDescription

from e2e.bench.receipts import Receipts
from e2e.bench.receiver import count_only
from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    import aiohttp
    from aiortc import RTCDataChannel
    from aiortc.rtp import RtpPacket

    from e2e.bench.receiver import CountedStream

FPS = 30.0
SIZE = "640x480"
# What a page does that only watches and has settled.
PING_INTERVAL_S = 1.0
REPORT_INTERVAL_S = 1.0
CONNECT_TIMEOUT_S = 20.0
KINDS: tuple[Literal["audio", "video"], ...] = ("audio", "video")


@dataclass(frozen=True, slots=True)
class Offering:
    """Where a server takes offers, and whether it speaks WAX over data channels."""

    url: str
    wax: bool


@dataclass(slots=True)
class StreamCounts:
    """Sums over the streams of one kind, since the connection was made."""

    packets: int = 0
    lost: int = 0
    octets: int = 0
    frames: int = 0


@dataclass(frozen=True, slots=True)
class ViewerCounts:
    """What one viewer has received."""

    video: StreamCounts
    audio: StreamCounts


class Viewer:
    """Connects, keeps itself alive as the page does, counts. `connect` raises `MeasureError`."""

    def __init__(self, offering: Offering) -> None:
        self._offering = offering
        self._peer = RTCPeerConnection(RTCConfiguration(iceServers=[]))
        self._streams: dict[str, dict[int, CountedStream]] = {}
        self._arrived = {kind: asyncio.Event() for kind in KINDS}
        self._tasks: list[asyncio.Task[None]] = []
        self._pong: tuple[int, float] | None = None
        self._state: RTCDataChannel | None = None
        self._receipts: Receipts | None = None

    async def connect(self, http: aiohttp.ClientSession) -> None:
        """Return when picture and sound arrive."""
        try:
            async with asyncio.timeout(CONNECT_TIMEOUT_S):
                await self._negotiate(http)
                for arrived in self._arrived.values():
                    await arrived.wait()
        except TimeoutError as error:
            missing = " and ".join(kind for kind in KINDS if not self._arrived[kind].is_set())
            raise MeasureError(
                f"{self._offering.url}: no {missing} in {CONNECT_TIMEOUT_S:g} s; "
                f"the connection is {self._peer.connectionState}"
            ) from error

    async def close(self) -> None:
        """Leave as a closed page does."""
        for task in self._tasks:
            task.cancel()
        await self._peer.close()

    def counts(self) -> ViewerCounts:
        return ViewerCounts(video=self._sum("video"), audio=self._sum("audio"))

    async def _negotiate(self, http: aiohttp.ClientSession) -> None:
        for kind in KINDS:
            receiver = self._peer.addTransceiver(kind, direction="recvonly").receiver
            came = partial(self._came, kind)
            self._streams[kind] = count_only(receiver, kind, self._arrived[kind], came)
        if self._offering.wax:
            self._open_channels()
        await self._peer.setLocalDescription(await self._peer.createOffer())
        request = {"sdp": self._peer.localDescription.sdp}
        request |= {"client": str(uuid.uuid4())} if self._offering.wax else {"type": "offer"}
        async with http.post(self._offering.url, json=request) as response:
            if response.status != 200:
                raise MeasureError(
                    f"{self._offering.url}: {response.status} {(await response.text())[:200]}"
                )
            answer = await response.json()
        await self._peer.setRemoteDescription(RTCSessionDescription(answer["sdp"], "answer"))

    def _open_channels(self) -> None:
        self._state = self._peer.createDataChannel("state")
        self._state.on("message", self._take_state)

        drive = self._peer.createDataChannel("drive", ordered=False, maxRetransmits=0)
        drive.on("open", lambda: self._start(drive))
        drive.on("message", self._take_pong)

    def _take_state(self, data: str | bytes) -> None:
        message = json.loads(data)
        if message["type"] == "hello":
            self._receipts = Receipts() if message.get("acknowledge") else None
            size = SIZE if SIZE in message["sizes"] else message["sizes"][0]
            want = {"type": "want", "sound": True, "picture": True, "size": size, "policy": None}
            self._tell(want)
        elif message["type"] == "units" and self._receipts is not None:
            for rtp in self._receipts.learn(message["last_rtp"], message["length"]):
                self._tell({"type": "received", "kind": "audio", "rtp": rtp})

    def _came(self, kind: Literal["audio", "video"], packet: RtpPacket) -> None:
        if self._receipts is not None and self._receipts.ends_unit(kind, packet):
            self._tell({"type": "received", "kind": kind, "rtp": packet.timestamp})

    def _tell(self, message: dict[str, object]) -> None:
        if self._state is not None and self._state.readyState == "open":
            self._state.send(json.dumps(message))

    def _start(self, drive: RTCDataChannel) -> None:
        self._tasks = [
            asyncio.create_task(self._ping(drive), name="ping"),
            asyncio.create_task(self._report(drive), name="report"),
        ]

    def _take_pong(self, data: str | bytes) -> None:
        _, number, *_ = json.loads(data)
        self._pong = (number, _now_ms())

    async def _ping(self, drive: RTCDataChannel) -> None:
        number = 0
        while drive.readyState == "open":
            number += 1
            now_ms = _now_ms()
            pong_id, pong_ms = self._pong or (None, None)
            held_ms = None if pong_ms is None else now_ms - pong_ms
            drive.send(json.dumps(["ping", number, now_ms, pong_id, held_ms]))
            await asyncio.sleep(PING_INTERVAL_S)

    async def _report(self, drive: RTCDataChannel) -> None:
        # Fifty pages do not report in the same millisecond, so neither do fifty viewers.
        await asyncio.sleep(random.uniform(0, REPORT_INTERVAL_S))
        sound, picture = [None] * 5, [None, None, FPS, None]
        report = json.dumps(["report", sound, picture, None])
        while drive.readyState == "open":
            drive.send(report)
            await asyncio.sleep(REPORT_INTERVAL_S)

    def _sum(self, kind: str) -> StreamCounts:
        total = StreamCounts()
        for stream in self._streams.get(kind, {}).values():
            total.packets += stream.packets_received
            total.lost += stream.packets_expected - stream.packets_received
            total.octets += stream.octets
            total.frames += stream.frames
        return total


def _now_ms() -> float:
    return time.monotonic() * 1000.0
