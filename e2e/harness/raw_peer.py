"""A viewer that is no browser: it sends whatever bytes a test wants on the two data channels."""

from __future__ import annotations

import json
import uuid
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
        for channel in (self.state, self.drive):
            channel.on("message", lambda data: self.heard.append(json.loads(data)))

    async def __aenter__(self) -> Self:
        for kind in ("audio", "video"):
            self.peer.addTransceiver(kind, direction="recvonly")
        await self.peer.setLocalDescription(await self.peer.createOffer())
        offer = {"sdp": self.peer.localDescription.sdp, "client": str(uuid.uuid4())}
        async with (
            aiohttp.ClientSession() as http,
            http.post(f"{self._server.url}/api/offer", json=offer) as response,
        ):
            assert response.status == 200, await response.text()
            answer = await response.json()
        await self.peer.setRemoteDescription(RTCSessionDescription(answer["sdp"], "answer"))
        await eventually(self._is_open, "both channels are open")
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        await self.peer.close()

    def newest(self, kind: str) -> dict[str, Any]:
        """Return the newest message of this type, empty when none came."""
        return next((m for m in reversed(self.heard) if m["type"] == kind), {})

    async def pongs(self, number: int) -> bool:
        """Send a ping and tell whether it is answered within a second."""
        ping = {"type": "ping", "id": number, "sent_page_ms": 1.0}
        self.drive.send(json.dumps(ping | {"pong_id": None, "pong_held_ms": None}))

        async def answered() -> bool:
            return any(m["type"] == "pong" and m["id"] == number for m in self.heard)

        try:
            return await eventually(answered, "a pong", within_s=1, every_s=0.02)
        except AssertionError:
            return False

    async def _is_open(self) -> bool:
        return self.state.readyState == self.drive.readyState == "open"
