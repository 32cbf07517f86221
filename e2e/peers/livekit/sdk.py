"""Publish by LiveKit's Python SDK, as its quick start has it, with simulcast."""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any, Final

from livekit import rtc

from e2e.peers.livekit.errors import LiveKitError
from e2e.peers.media import BITRATE_BPS
from wax.capture.source import SAMPLE_RATE_HZ

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable

    from wax.capture.source import AudioSource, VideoSource

FPS: Final = 30
SIZE: Final = (640, 480)


@asynccontextmanager
async def published(
    url: str, token: str, camera: VideoSource, microphone: AudioSource
) -> AsyncIterator[Callable[[], Awaitable[str]]]:
    """Publish inside the block; what is yielded waits until that ends, and says why.

    Raises `LiveKitError` where the server refuses.
    """
    room = rtc.Room()
    over: asyncio.Future[str] = asyncio.get_running_loop().create_future()

    def disconnected(reason: object) -> None:
        if not over.done():
            over.set_result(f"the room was left ({reason})")

    room.on("disconnected", disconnected)
    try:
        await room.connect(url, token)
    except rtc.ConnectError as error:
        raise LiveKitError(f"{url} refuses the publisher: {error}") from error
    video, audio = rtc.VideoSource(*SIZE), rtc.AudioSource(SAMPLE_RATE_HZ, 1)
    threads = ThreadPoolExecutor(max_workers=2, thread_name_prefix="capture")
    capturing: list[asyncio.Task[None]] = []
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
        capturing += [
            asyncio.create_task(_show(camera, video, threads)),
            asyncio.create_task(_sound(microphone, audio, threads)),
        ]

        async def ended() -> str:
            first: list[asyncio.Future[Any]] = [over, *capturing]
            await asyncio.wait(first, return_when=asyncio.FIRST_COMPLETED)
            for task in capturing:
                if task.done():
                    task.result()
            return await over

        yield ended
    finally:
        for task in capturing:
            task.cancel()
        await asyncio.gather(*capturing, return_exceptions=True)
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
