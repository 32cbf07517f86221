"""WHIP, RFC 9725: publish by one HTTP request with an offer, leave by another."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING, Final
from urllib.parse import urljoin

import aiohttp
from aiortc import (
    RTCConfiguration,
    RTCPeerConnection,
    RTCRtpSender,
    RTCSessionDescription,
)

from e2e.peers.livekit.errors import LiveKitError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterable

    from aiortc import MediaStreamTrack

CONNECT_WITHIN_S: Final = 10.0
_LEAVE_WITHIN_S: Final = 1.0
_CODECS: Final = {"video": ("video/VP8", "video/rtx"), "audio": ("audio/opus",)}


class PublishError(LiveKitError):
    """It did not work out this time; trying again may help."""


class RefusedError(LiveKitError):
    """The server will not have it, however often it is asked."""


class Publication:
    """A connection that sends; `await ended()` returns when it no longer does."""

    def __init__(self) -> None:
        self.peer = RTCPeerConnection(RTCConfiguration(iceServers=[]))
        self._changed = asyncio.Event()
        self.peer.on("connectionstatechange", self._changed.set)

    async def connected(self) -> None:
        """Wait until it sends. Raises `PublishError` when it fails instead."""
        await self._until({"connected", "failed", "closed"})
        if self.peer.connectionState != "connected":
            raise PublishError(f"the connection to LiveKit is {self.peer.connectionState}")

    async def ended(self) -> str:
        """Return the state in which it ended."""
        await self._until({"failed", "closed"})
        return self.peer.connectionState

    async def _until(self, states: set[str]) -> None:
        while self.peer.connectionState not in states:
            self._changed.clear()
            await self._changed.wait()


@asynccontextmanager
async def published(
    http: aiohttp.ClientSession, endpoint: str, token: str, tracks: Iterable[MediaStreamTrack]
) -> AsyncIterator[Publication]:
    """Publish inside the block, leave after it.

    Raises `RefusedError` where the server refuses, `PublishError` where it is not reached or
    fails.
    """
    publication = Publication()
    resource: str | None = None
    headers = {"Authorization": f"Bearer {token}"}
    try:
        for track in tracks:
            _add(publication.peer, track)
        try:
            async with asyncio.timeout(CONNECT_WITHIN_S):
                resource = await _offer(http, endpoint, headers, publication.peer)
                await publication.connected()
        except TimeoutError:
            raise PublishError(
                f"{endpoint} gave no connection within {CONNECT_WITHIN_S:g} s"
            ) from None
        yield publication
    finally:
        if resource is not None:
            with suppress(aiohttp.ClientError, TimeoutError):
                async with asyncio.timeout(_LEAVE_WITHIN_S):
                    await http.delete(resource, headers=headers)
        await publication.peer.close()


def _add(peer: RTCPeerConnection, track: MediaStreamTrack) -> None:
    transceiver = peer.addTransceiver(track, direction="sendonly")
    wanted = _CODECS[track.kind]
    known = RTCRtpSender.getCapabilities(track.kind).codecs
    transceiver.setCodecPreferences([codec for codec in known if codec.mimeType in wanted])


async def _offer(
    http: aiohttp.ClientSession,
    endpoint: str,
    headers: dict[str, str],
    peer: RTCPeerConnection,
) -> str | None:
    """Offer, take the answer, return the address by which one leaves, if the server gave one."""
    await peer.setLocalDescription(await peer.createOffer())
    try:
        async with http.post(
            endpoint,
            data=peer.localDescription.sdp.encode(),
            headers={**headers, "Content-Type": "application/sdp"},
        ) as answer:
            text = await answer.text()
            if answer.status != 201:
                kind = RefusedError if 400 <= answer.status < 500 else PublishError
                raise kind(f"{endpoint} answered {answer.status}: {text.strip()[:200]}")
            location = answer.headers.get("Location")
    except aiohttp.ClientError as error:
        raise PublishError(f"{endpoint} is not reached: {error}") from error
    try:
        await peer.setRemoteDescription(RTCSessionDescription(text, "answer"))
    except ValueError as error:
        raise PublishError(f"{endpoint} gave an answer that cannot be used: {error}") from error
    return urljoin(endpoint, location) if location else None
