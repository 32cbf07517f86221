"""A stock aiortc server to compare with: what aiortc's own examples lead to, one encoder per peer.

It has the same work as WAX: the same test card through `MediaRelay`, VP8 640×480 at 30 fps and
1 Mbit/s, Opus. It differs from the examples where they would spoil the comparison: no STUN
server is asked (that alone would cost seconds), and VP8 starts at WAX's bit rate.
"""

from __future__ import annotations

import argparse
import asyncio
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from typing import TYPE_CHECKING

import aiortc.codecs.vpx
import numpy as np
from aiohttp import web
from aiortc import (
    MediaStreamTrack,
    RTCConfiguration,
    RTCPeerConnection,
    RTCSessionDescription,
)
from aiortc.contrib.media import MediaRelay
from av import AudioFrame, VideoFrame

from wax.clock import SystemClock
from wax.config import AudioSettings, VideoSettings
from wax.media.source import SAMPLE_RATE_HZ
from wax.media.testcard import TestCardAudio, TestCardVideo

if TYPE_CHECKING:
    from wax.media.source import AudioSource, VideoSource

VIDEO_CLOCK_HZ = 90_000
OPUS_FRAME_SAMPLES = SAMPLE_RATE_HZ // 50
BITRATE_BPS = 1_000_000

PAGE = """<!doctype html>
<meta charset="utf-8">
<title>stock aiortc</title>
<video id="video" autoplay muted playsinline></video>
<script>
const peer = new RTCPeerConnection();
peer.addTransceiver("video", { direction: "recvonly" });
peer.addTransceiver("audio", { direction: "recvonly" });
peer.addEventListener("track", (event) => {
  if (event.track.kind === "video") {
    document.getElementById("video").srcObject = event.streams[0];
  }
});
const gathered = new Promise((resolve) => {
  peer.addEventListener("icegatheringstatechange", () => {
    if (peer.iceGatheringState === "complete") resolve();
  });
});
async function negotiate() {
  await peer.setLocalDescription(await peer.createOffer());
  await gathered;
  const { sdp, type } = peer.localDescription;
  const response = await fetch("/offer", {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify({ sdp, type }),
  });
  await peer.setRemoteDescription(await response.json());
}
negotiate();
addEventListener("pagehide", () => peer.close());
</script>
"""


class CameraTrack(MediaStreamTrack):
    """Reads a camera in a thread, as aiortc's `MediaPlayer` does."""

    kind = "video"

    def __init__(self, source: VideoSource) -> None:
        super().__init__()
        self._source = source
        self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="camera")

    async def recv(self) -> VideoFrame:
        loop = asyncio.get_running_loop()
        picture = await loop.run_in_executor(self._thread, self._source.read)
        frame = VideoFrame.from_ndarray(picture.i420, format="yuv420p")
        frame.pts = round(picture.captured_s * VIDEO_CLOCK_HZ)
        frame.time_base = Fraction(1, VIDEO_CLOCK_HZ)
        return frame


class MicrophoneTrack(MediaStreamTrack):
    """Reads a microphone in a thread and cuts its sound into pieces of 20 ms."""

    kind = "audio"

    def __init__(self, source: AudioSource) -> None:
        super().__init__()
        self._source = source
        self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="microphone")
        self._samples = np.zeros(0, dtype=np.int16)
        self._position = 0

    async def recv(self) -> AudioFrame:
        loop = asyncio.get_running_loop()
        while len(self._samples) < OPUS_FRAME_SAMPLES:
            sound = await loop.run_in_executor(self._thread, self._source.read)
            self._samples = np.concatenate([self._samples, sound.samples])
        piece = self._samples[:OPUS_FRAME_SAMPLES]
        self._samples = self._samples[OPUS_FRAME_SAMPLES:]
        frame = AudioFrame.from_ndarray(piece.reshape(1, -1), format="s16", layout="mono")
        frame.sample_rate = SAMPLE_RATE_HZ
        frame.pts = self._position
        frame.time_base = Fraction(1, SAMPLE_RATE_HZ)
        self._position += OPUS_FRAME_SAMPLES
        return frame


class Room:
    """Camera, microphone and everybody who watches."""

    def __init__(self, camera: VideoSource, microphone: AudioSource) -> None:
        self._relay = MediaRelay()
        self._video = CameraTrack(camera)
        self._audio = MicrophoneTrack(microphone)
        self._peers: set[RTCPeerConnection] = set()

    async def page(self, request: web.Request) -> web.Response:
        return web.Response(text=PAGE, content_type="text/html")

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
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=8081)
    arguments = parser.parse_args()

    # The field's usual way to set the bit rate; aiortc has no public one.
    aiortc.codecs.vpx.DEFAULT_BITRATE = BITRATE_BPS

    clock = SystemClock()
    camera = TestCardVideo(VideoSettings(source="testcard"), clock)
    microphone = TestCardAudio(AudioSettings(source="testcard"), clock)
    camera.open()
    microphone.open()
    try:
        room = Room(camera, microphone)
        app = web.Application()
        app.router.add_get("/", room.page)
        app.router.add_get("/healthz", room.healthz)
        app.router.add_post("/offer", room.offer)
        app.on_shutdown.append(room.close)
        web.run_app(app, host=arguments.host, port=arguments.port, print=None)
    finally:
        camera.close()
        microphone.close()


if __name__ == "__main__":
    main()
