"""A viewer of Janus's streaming plugin, by its HTTP API: the server offers, the viewer answers."""

from __future__ import annotations

import secrets
from typing import TYPE_CHECKING, Any, Final

import aiohttp
from aiortc import RTCConfiguration, RTCPeerConnection, RTCSessionDescription

from e2e.peers.janus import MOUNTPOINT
from wax.client.media import Media
from wax.errors import SignallingError

if TYPE_CHECKING:
    from collections.abc import Callable

_PLUGIN: Final = "janus.plugin.streaming"


class JanusViewer:
    """Watches the one mountpoint; `url` is the API's."""

    def __init__(self, url: str, on_socket: Callable[[Any], None] | None) -> None:
        self.peer = RTCPeerConnection(RTCConfiguration(iceServers=[]))
        self.media = Media(self.peer, on_socket=on_socket)
        self._url = url
        self._http: aiohttp.ClientSession | None = None

    async def connect(self) -> None:
        """Begin to watch; raises `SignallingError` if Janus refuses."""
        self._http = aiohttp.ClientSession(raise_for_status=True)
        session = (await self._post(self._url, {"janus": "create"}))["data"]["id"]
        self._url = f"{self._url}/{session}"
        handle = (await self._post(self._url, {"janus": "attach", "plugin": _PLUGIN}))["data"]["id"]
        to = f"{self._url}/{handle}"
        await self._ask(to, {"request": "watch", "id": MOUNTPOINT})
        offer = await self._offer()
        await self.peer.setRemoteDescription(RTCSessionDescription(offer, "offer"))
        await self.peer.setLocalDescription(await self.peer.createAnswer())
        self.media.attach(offer)
        answer = {"type": "answer", "sdp": self.peer.localDescription.sdp}
        await self._ask(to, {"request": "start"}, answer)

    async def close(self) -> None:
        await self.peer.close()
        await self.media.close()
        if self._http is not None:
            await self._http.close()

    async def _ask(
        self, url: str, body: dict[str, Any], jsep: dict[str, str] | None = None
    ) -> None:
        message = {"janus": "message", "body": body}
        await self._post(url, message if jsep is None else message | {"jsep": jsep})

    async def _offer(self) -> str:
        """Wait for the plugin's answer to `watch`, which comes as an event."""
        assert self._http is not None
        while True:
            async with self._http.get(self._url) as response:
                event = await response.json()
            if "jsep" in event:
                sdp: str = event["jsep"]["sdp"]
                return sdp
            if "error_code" in (event.get("plugindata") or {}).get("data", {}):
                raise SignallingError(f"Janus refuses: {event['plugindata']['data']['error']}")

    async def _post(self, url: str, message: dict[str, Any]) -> dict[str, Any]:
        assert self._http is not None
        async with self._http.post(
            url, json=message | {"transaction": secrets.token_hex(6)}
        ) as response:
            answer: dict[str, Any] = await response.json()
        if answer.get("janus") == "error":
            raise SignallingError(f"Janus refuses: {answer['error']['reason']}")
        return answer
