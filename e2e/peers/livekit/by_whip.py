"""Publish one layer by WHIP (RFC 9725), from aiortc: a request with an offer, one to leave."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import TYPE_CHECKING, Final
from urllib.parse import urljoin

import aiohttp
from aiortc import RTCConfiguration, RTCPeerConnection, RTCRtpSender, RTCSessionDescription

from e2e.peers.livekit.errors import LiveKitError
from e2e.peers.media import CameraTrack, MicrophoneTrack

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.capture.source import AudioSource, VideoSource

_LEAVE_WITHIN_S: Final = 1.0
_CODECS: Final = {"video": ("video/VP8", "video/rtx"), "audio": ("audio/opus",)}


async def publish(
    url: str, token: str, camera: VideoSource, microphone: AudioSource, begun: Callable[[], None]
) -> None:
    """Publish until that ends; raises `LiveKitError`, which says why."""
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
                raise LiveKitError(f"{endpoint} answered {answer.status}: {text.strip()[:200]}")
            resource = urljoin(endpoint, answer.headers["Location"])
            await peer.setRemoteDescription(RTCSessionDescription(text, "answer"))
            while peer.connectionState not in {"failed", "closed"}:
                if peer.connectionState == "connected":
                    begun()
                changed.clear()
                await changed.wait()
            raise LiveKitError(f"the publisher's connection to LiveKit is {peer.connectionState}")
        except aiohttp.ClientError as error:
            raise LiveKitError(f"{endpoint} is not reached: {error}") from error
        finally:
            if resource is not None:
                with suppress(aiohttp.ClientError, TimeoutError):
                    async with asyncio.timeout(_LEAVE_WITHIN_S):
                        await http.delete(resource)
            await peer.close()
