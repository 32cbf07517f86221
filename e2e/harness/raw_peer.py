"""A viewer that is no browser: it sends whatever bytes a test wants on the two data channels."""

from __future__ import annotations

import asyncio
import itertools
import json
import time
import uuid
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Self

import aiohttp
from aiortc import RTCConfiguration, RTCPeerConnection, RTCSessionDescription

from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from types import TracebackType

    from aiortc import RTCDataChannel

    from e2e.harness.server import Server


class RawPeer:
    """Use as an async context manager; inside, both channels are open."""

    def __init__(self, server: Server) -> None:
        self._server = server
        self.peer = RTCPeerConnection(RTCConfiguration(iceServers=[]))
        self.state: RTCDataChannel = self.peer.createDataChannel("state")
        self.drive: RTCDataChannel = self.peer.createDataChannel(
            "drive", ordered=False, maxRetransmits=0
        )
        self.heard: list[dict[str, Any]] = []
        self._pings = itertools.count(1)
        self._answered: set[int] = set()
        self._heartbeat: asyncio.Task[None] | None = None
        self._ahead_ms = 0.0
        self.state.on("message", lambda data: self.heard.append(json.loads(data)))
        self.drive.on("message", self._take_pong)

    async def __aenter__(self) -> Self:
        for kind in ("audio", "video"):
            self.peer.addTransceiver(kind, direction="recvonly")
        await self.peer.setLocalDescription(await self.peer.createOffer())
        answer = await self._answer(self.peer.localDescription.sdp)
        await self.peer.setRemoteDescription(RTCSessionDescription(answer, "answer"))
        await eventually(self._is_open, "both channels are open", every_s=0.01)
        self._heartbeat = asyncio.create_task(self._beat(), name="heartbeat")
        return self

    async def _answer(self, offer: str) -> str:
        """Exchange the descriptions."""
        async with (
            aiohttp.ClientSession() as http,
            http.post(
                f"{self._server.url}/api/offer", json={"sdp": offer, "client": str(uuid.uuid4())}
            ) as response,
        ):
            assert response.status == 200, await response.text()
            return str((await response.json())["sdp"])

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._heartbeat is not None:
            self._heartbeat.cancel()
            with suppress(asyncio.CancelledError):
                await self._heartbeat
        await self.peer.close()

    def newest(self, kind: str) -> dict[str, Any]:
        """Return the newest of this type on the state channel, empty when none came."""
        return next((m for m in reversed(self.heard) if m["type"] == kind), {})

    def server_ms(self) -> float:
        """Return the server's clock, good to a round trip on this machine; ask after `pongs`."""
        return time.monotonic() * 1000 + self._ahead_ms

    async def pongs(self) -> bool:
        """Send a ping and tell whether it is answered within a second."""
        number = self._ping()

        async def answered() -> bool:
            return number in self._answered

        try:
            return await eventually(answered, "a pong", within_s=1, every_s=0.02)
        except AssertionError:
            return False

    def _take_pong(self, data: str | bytes) -> None:
        _, number, _, server_ms = json.loads(data)
        self._answered.add(number)
        self._ahead_ms = server_ms - time.monotonic() * 1000

    def _ping(self) -> int:
        number = next(self._pings)
        self.drive.send(f'["ping",{number},1.0,null,null]')
        return number

    async def _beat(self) -> None:
        while self.drive.readyState == "open":
            self._ping()
            await asyncio.sleep(0.2)

    async def _is_open(self) -> bool:
        return self.state.readyState == self.drive.readyState == "open"
