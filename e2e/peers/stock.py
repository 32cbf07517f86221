"""A stock aiortc server to compare with: ``python -m e2e.peers.stock HOST PORT [SIZE]``.

It is what aiortc's own examples lead to, one encoder per peer. It has the same work as WAX: the
same test card, through `MediaRelay`, VP8 640×480 at 30 fps and 1 Mbit/s, or another size of
`e2e.peers.sizes`, and Opus. It differs from the examples where they would spoil the comparison: it
asks no STUN server (that alone would cost seconds), and VP8 starts at WAX's bit rate.
"""

from __future__ import annotations

import asyncio
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Final, cast

from aiohttp import web
from aiortc import RTCConfiguration, RTCPeerConnection, RTCSessionDescription
from aiortc.contrib.media import MediaRelay

from e2e.peers.media import CameraTrack, MicrophoneTrack, set_bitrate, sources
from e2e.peers.sizes import SIZES, VGA

if TYPE_CHECKING:
    from e2e.peers.sizes import SizeName
    from wax.capture.source import AudioSource, VideoSource

PAGE: Final = Path(__file__).with_name("stock.html")


class Room:
    """Camera, microphone and everybody who watches."""

    def __init__(self, camera: VideoSource, microphone: AudioSource) -> None:
        self._relay = MediaRelay()
        self._video = CameraTrack(camera)
        self._audio = MicrophoneTrack(microphone)
        self._peers: set[RTCPeerConnection] = set()

    async def page(self, request: web.Request) -> web.Response:
        return web.Response(text=PAGE.read_text(encoding="utf-8"), content_type="text/html")

    async def healthz(self, request: web.Request) -> web.Response:
        return web.Response(text="ok")

    async def offer(self, request: web.Request) -> web.Response:
        asked = await request.json()
        peer = RTCPeerConnection(RTCConfiguration(iceServers=[]))
        self._peers.add(peer)

        @peer.on("connectionstatechange")
        async def on_change() -> None:
            if peer.connectionState in {"failed", "closed"}:
                self._peers.discard(peer)
                await peer.close()

        peer.addTrack(self._relay.subscribe(self._audio))
        peer.addTrack(self._relay.subscribe(self._video))
        await peer.setRemoteDescription(RTCSessionDescription(asked["sdp"], asked["type"]))
        await peer.setLocalDescription(await peer.createAnswer())
        answer = peer.localDescription
        return web.json_response({"sdp": answer.sdp, "type": answer.type})

    async def close(self, app: web.Application) -> None:
        await asyncio.gather(*(peer.close() for peer in list(self._peers)))
        self._video.stop()
        self._audio.stop()


def main() -> None:
    host, port, *name = sys.argv[1:]
    size = SIZES[cast("SizeName", name[0])] if name else VGA
    set_bitrate(size)
    with sources(size) as (camera, microphone):
        room = Room(camera, microphone)
        app = web.Application()
        app.router.add_get("/", room.page)
        app.router.add_get("/healthz", room.healthz)
        app.router.add_post("/offer", room.offer)
        app.on_shutdown.append(room.close)
        web.run_app(app, host=host, port=int(port), print=None)


if __name__ == "__main__":
    main()
