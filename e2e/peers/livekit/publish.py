"""Publish the test card to LiveKit: by its SDK or by WHIP, until that ends."""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import TYPE_CHECKING, Final
from urllib.parse import urljoin

import aiohttp
from aiortc import RTCConfiguration, RTCPeerConnection, RTCRtpSender, RTCSessionDescription
from livekit import rtc

from e2e.measure.errors import MeasureError
from e2e.peers.media import CameraTrack, MicrophoneTrack
from e2e.peers.sizes import FPS
from wax.capture.source import SAMPLE_RATE_HZ

if TYPE_CHECKING:
    from collections.abc import Callable

    from e2e.peers.sizes import Size
    from wax.capture.source import AudioSource, VideoSource

_LEAVE_WITHIN_S: Final = 1.0
_CODECS: Final = {"video": ("video/VP8", "video/rtx"), "audio": ("audio/opus",)}


async def by_sdk(
    url: str,
    token: str,
    camera: VideoSource,
    microphone: AudioSource,
    begun: Callable[[], None],
    *,
    size: Size,
) -> None:
    """Publish with simulcast, as in LiveKit's quick start; raises `MeasureError` at the end."""
    room = rtc.Room()
    over: asyncio.Future[None] = asyncio.get_running_loop().create_future()

    def disconnected(reason: object) -> None:
        if not over.done():
            over.set_exception(MeasureError(f"the publisher's room was left ({reason})"))

    room.on("disconnected", disconnected)
    try:
        await room.connect(url, token)
    except rtc.ConnectError as error:
        raise MeasureError(f"{url} refuses the publisher: {error}") from error
    video, audio = rtc.VideoSource(size.width, size.height), rtc.AudioSource(SAMPLE_RATE_HZ, 1)
    threads = ThreadPoolExecutor(max_workers=2, thread_name_prefix="capture")
    works: list[asyncio.Future[None]] = [over]
    try:
        await room.local_participant.publish_track(
            rtc.LocalVideoTrack.create_video_track("camera", video),
            rtc.TrackPublishOptions(
                source=rtc.TrackSource.SOURCE_CAMERA,
                simulcast=True,
                video_encoding=rtc.VideoEncoding(max_framerate=FPS, max_bitrate=size.bitrate_bps),
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


async def by_whip(
    url: str, token: str, camera: VideoSource, microphone: AudioSource, begun: Callable[[], None]
) -> None:
    """Publish one layer, by WHIP (RFC 9725) from aiortc; raises `MeasureError` at the end."""
    peer = RTCPeerConnection(RTCConfiguration(iceServers=[]))
    headers, resource = {"Authorization": f"Bearer {token}"}, None
    changed = asyncio.Event()
    peer.on("connectionstatechange", changed.set)
    for track in (MicrophoneTrack(microphone), CameraTrack(camera)):
        transceiver = peer.addTransceiver(track, direction="sendonly")
        known = RTCRtpSender.getCapabilities(track.kind).codecs
        wanted = [codec for codec in known if codec.mimeType in _CODECS[track.kind]]
        transceiver.setCodecPreferences(wanted)
    endpoint = f"{url}/whip/v1"
    async with aiohttp.ClientSession(headers=headers) as http:
        try:
            await peer.setLocalDescription(await peer.createOffer())
            sdp, kind = peer.localDescription.sdp.encode(), {"Content-Type": "application/sdp"}
            async with http.post(endpoint, data=sdp, headers=kind) as answer:
                text = await answer.text()
            if answer.status != 201:
                raise MeasureError(f"{endpoint} answered {answer.status}: {text.strip()[:200]}")
            resource = urljoin(endpoint, answer.headers["Location"])
            await peer.setRemoteDescription(RTCSessionDescription(text, "answer"))
            while peer.connectionState not in {"failed", "closed"}:
                if peer.connectionState == "connected":
                    begun()
                changed.clear()
                await changed.wait()
            raise MeasureError(f"the publisher's connection to LiveKit is {peer.connectionState}")
        except aiohttp.ClientError as error:
            raise MeasureError(f"{endpoint} is not reached: {error}") from error
        finally:
            if resource is not None:
                with suppress(aiohttp.ClientError, TimeoutError):
                    async with asyncio.timeout(_LEAVE_WITHIN_S):
                        await http.delete(resource)
            await peer.close()
