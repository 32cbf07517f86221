"""What a media server receives of the driving view."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from typing import TYPE_CHECKING, Final, Literal

import numpy as np
import pytest
from aiortc import RTCPeerConnection, RTCSessionDescription
from av import VideoFrame
from tests.encode.quarters import CORNERS, corners, quartered
from tests.open_boundary import OpenFence

from wax.clock import SystemClock
from wax.config.video import DrivingViewSettings
from wax.fanout.video_hub import VideoHub
from wax.rtc.publisher import Publisher
from wax.streams.interface import Codecs

if TYPE_CHECKING:
    from aiortc import MediaStreamTrack
    from numpy.typing import NDArray

pytestmark = pytest.mark.system

SIZES: Final = [(480, 270), (270, 480), (640, 480), (98, 66)]
"""The first two and the last have an odd number of rows or columns of chroma."""


async def show(hub: VideoHub) -> None:
    """Capture 30 pictures a second."""
    clock, picture = SystemClock(), quartered(640, 480)
    while True:
        hub.slot.put(replace(picture, captured_s=clock.now_s()))
        await asyncio.sleep(1 / 30)


async def comes(track: MediaStreamTrack, size: tuple[int, int]) -> NDArray[np.uint8]:
    """Wait for a picture of this size and return it."""
    while True:
        frame = await track.recv()
        assert isinstance(frame, VideoFrame)
        if (frame.width, frame.height) == size:
            return np.asarray(frame.to_ndarray(format="yuv420p"), np.uint8)


@pytest.mark.parametrize("codec", ["vp8", "h264"])
async def test_each_size_of_the_ladder_is_published_as_it_is(codec: Literal["vp8", "h264"]) -> None:
    """A media server decodes wide, standing and tiny pictures, each in its own size."""
    steps = [
        {"width": width, "height": height, "fps": 30, "bitrate_bps": 900_000 - 100_000 * at}
        for at, (width, height) in enumerate(SIZES)
    ]
    settings = DrivingViewSettings.model_validate({"codec": codec, "renditions": steps})
    hub = VideoHub(settings=settings, clock=SystemClock())
    hub.start()
    lane = hub.add(OpenFence())
    publisher = Publisher(
        codecs=Codecs("opus", codec),
        video=lane,
        audio=None,
        clock=SystemClock(),
        on_keyframe_wanted=lambda: hub.request_keyframe(lane),
    )
    server = RTCPeerConnection()
    tracks: list[MediaStreamTrack] = []
    server.on("track", tracks.append)
    camera = asyncio.create_task(show(hub))
    try:
        async with asyncio.timeout(20):
            offer = RTCSessionDescription(await publisher.offer(), "offer")
            await server.setRemoteDescription(offer)
            await server.setLocalDescription(await server.createAnswer())
            await publisher.accept(server.localDescription.sdp)
            await publisher.connected()
            for name, size in zip(hub.names, SIZES, strict=True):
                hub.choose(lane, name)
                seen = corners(await comes(tracks[0], size))
                assert np.abs(np.array(seen) - np.array(CORNERS)).max() < 24
    finally:
        camera.cancel()
        await publisher.close()
        await server.close()
        hub.stop()
