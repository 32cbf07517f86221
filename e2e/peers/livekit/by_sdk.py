"""Publish by LiveKit's Python SDK, as its quick start has it, with simulcast."""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Final

from livekit import rtc

from e2e.peers.livekit.errors import LiveKitError
from e2e.peers.media import BITRATE_BPS
from wax.capture.source import SAMPLE_RATE_HZ

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.capture.source import AudioSource, VideoSource

FPS: Final = 30
SIZE: Final = (640, 480)


async def publish(
    url: str, token: str, camera: VideoSource, microphone: AudioSource, begun: Callable[[], None]
) -> None:
    """Publish until that ends; raises `LiveKitError`, which says why."""
    room = rtc.Room()
    over: asyncio.Future[None] = asyncio.get_running_loop().create_future()

    def disconnected(reason: object) -> None:
        if not over.done():
            over.set_exception(LiveKitError(f"the publisher's room was left ({reason})"))

    room.on("disconnected", disconnected)
    try:
        await room.connect(url, token)
    except rtc.ConnectError as error:
        raise LiveKitError(f"{url} refuses the publisher: {error}") from error
    video, audio = rtc.VideoSource(*SIZE), rtc.AudioSource(SAMPLE_RATE_HZ, 1)
    threads = ThreadPoolExecutor(max_workers=2, thread_name_prefix="capture")
    works: list[asyncio.Future[None]] = [over]
    try:
        await room.local_participant.publish_track(
            rtc.LocalVideoTrack.create_video_track("camera", video),
            rtc.TrackPublishOptions(
                source=rtc.TrackSource.SOURCE_CAMERA,
                simulcast=True,
                video_encoding=rtc.VideoEncoding(max_framerate=FPS, max_bitrate=BITRATE_BPS),
            ),
        )
        await room.local_participant.publish_track(
            rtc.LocalAudioTrack.create_audio_track("microphone", audio),
            rtc.TrackPublishOptions(source=rtc.TrackSource.SOURCE_MICROPHONE),
        )
        works += map(
            asyncio.ensure_future,
            (_show(camera, video, threads), _sound(microphone, audio, threads)),
        )
        begun()
        await asyncio.gather(*works)
    finally:
        for work in works:
            work.cancel()
        await asyncio.gather(*works, return_exceptions=True)
        threads.shutdown(wait=False)
        await room.disconnect()


async def _show(camera: VideoSource, video: rtc.VideoSource, threads: ThreadPoolExecutor) -> None:
    loop = asyncio.get_running_loop()
    while True:
        i420 = (await loop.run_in_executor(threads, camera.read)).i420
        height, width = i420.shape[0] * 2 // 3, i420.shape[1]
        frame = rtc.VideoFrame(width, height, rtc.VideoBufferType.I420, i420.tobytes())
        video.capture_frame(frame)


async def _sound(
    microphone: AudioSource, audio: rtc.AudioSource, threads: ThreadPoolExecutor
) -> None:
    loop = asyncio.get_running_loop()
    while True:
        samples = (await loop.run_in_executor(threads, microphone.read)).samples
        frame = rtc.AudioFrame(samples.tobytes(), SAMPLE_RATE_HZ, 1, len(samples))
        await audio.capture_frame(frame)
