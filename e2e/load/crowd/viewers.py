"""Viewers of the systems compared: a server that takes an offer, and Janus, which makes one."""

from __future__ import annotations

import secrets
from typing import TYPE_CHECKING, Any, Final

import aiohttp
from aiortc import RTCConfiguration, RTCPeerConnection, RTCSessionDescription

from e2e.peers.janus import MOUNTPOINT
from wax.client.media import Media
from wax.client.sdp import as_browser
from wax.errors import SignallingError

if TYPE_CHECKING:
    from collections.abc import Callable

_PLUGIN: Final = "janus.plugin.streaming"


class StockViewer:
    """A viewer of a server that speaks nothing but WebRTC, and takes offers at ``/offer``."""

    def __init__(self, url: str, on_socket: Callable[[Any], None] | None) -> None:
        self.peer = RTCPeerConnection(RTCConfiguration(iceServers=[]))
        self.media = Media(self.peer, on_socket=on_socket)
        self._url = url
        self._http = aiohttp.ClientSession(raise_for_status=True)

    async def connect(self) -> None:
        await self.peer.setLocalDescription(await self.peer.createOffer())
        offer = {"sdp": as_browser(self.peer.localDescription.sdp), "type": "offer"}
        async with self._http.post(f"{self._url}/offer", json=offer) as response:
            answer = await response.json()
        await self.peer.setRemoteDescription(RTCSessionDescription(answer["sdp"], "answer"))
        self.media.attach(answer["sdp"])

    async def close(self) -> None:
        await self.peer.close()
        await self.media.close()
        await self._http.close()


class JanusViewer(StockViewer):
    """Watches the one mountpoint of Janus's streaming plugin; `url` is its HTTP API's."""

    async def connect(self) -> None:
        """Begin to watch; raises `SignallingError` if Janus refuses."""
        session = (await self._post(self._url, janus="create"))["data"]["id"]
        events = f"{self._url}/{session}"
        handle = (await self._post(events, janus="attach", plugin=_PLUGIN))["data"]["id"]
        to = f"{events}/{handle}"
        watch = {"request": "watch", "id": MOUNTPOINT}
        await self._post(to, janus="message", body=watch)
        offer = await self._offer(events)
        await self.peer.setRemoteDescription(RTCSessionDescription(offer, "offer"))
        await self.peer.setLocalDescription(await self.peer.createAnswer())
        self.media.attach(offer)
        answer = {"type": "answer", "sdp": self.peer.localDescription.sdp}
        await self._post(to, janus="message", body={"request": "start"}, jsep=answer)

    async def _offer(self, events: str) -> str:
        """Wait for the plugin's answer to `watch`, which comes as an event."""
        while True:
            async with self._http.get(events) as response:
                event = await response.json()
            if "jsep" in event:
                return str(event["jsep"]["sdp"])
            if "error_code" in (data := (event.get("plugindata") or {}).get("data", {})):
                raise SignallingError(f"Janus refuses: {data['error']}")

    async def _post(self, url: str, **message: Any) -> dict[str, Any]:
        message |= {"transaction": secrets.token_hex(6)}
        async with self._http.post(url, json=message) as response:
            answer: dict[str, Any] = await response.json()
        if answer.get("janus") == "error":
            raise SignallingError(f"Janus refuses: {answer['error']['reason']}")
        return answer
