"""Somebody who watches in a room by LiveKit's own SDK."""

from __future__ import annotations

import asyncio
import json
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

from livekit import rtc

from e2e.harness.wait import until

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Mapping


class Watcher:
    """Records what arrives: the size of pictures by the robot's rendition, and audible sound."""

    def __init__(self) -> None:
        self.pictures: dict[str, set[tuple[int, int]]] = {}
        self.mime_types: list[str] = []
        self.told: list[dict[str, Any]] = []
        self.is_out = False
        self._loud = 0
        self._reading: list[asyncio.Task[None]] = []

    async def watches(self) -> None:
        await until(
            lambda: len(self.pictures) == 2 and self._loud > 10 and len(self.told) > 1,
            "two renditions, sound and news come",
            within_s=15,
        )

    async def leaves(self) -> None:
        await until(lambda: self.is_out, "it is taken out of the room")

    def subscribed(
        self, track: Any, publication: rtc.RemoteTrackPublication, robot: rtc.RemoteParticipant
    ) -> None:
        self.mime_types.append(publication.mime_type)
        is_video = publication.kind == rtc.TrackKind.KIND_VIDEO
        read = self._see(track, robot.identity) if is_video else self._hear(track)
        self._reading.append(asyncio.create_task(read))

    def heard(self, packet: rtc.DataPacket) -> None:
        self.told.append(json.loads(packet.data))

    def left(self, _: object) -> None:
        self.is_out = True

    async def close(self) -> None:
        for task in self._reading:
            task.cancel()
        await asyncio.gather(*self._reading, return_exceptions=True)

    async def _see(self, track: rtc.Track, who: str) -> None:
        async for event in rtc.VideoStream(track):
            size = (event.frame.width, event.frame.height)
            self.pictures.setdefault(who, set()).add(size)

    async def _hear(self, track: rtc.Track) -> None:
        async for event in rtc.AudioStream(track):
            self._loud += any(event.frame.data)


@asynccontextmanager
async def watching(seat: Mapping[str, str]) -> AsyncIterator[Watcher]:
    """Watch inside the block; raises `rtc.ConnectError` if LiveKit refuses the seat's token."""
    watcher, room = Watcher(), rtc.Room()
    room.on("track_subscribed", watcher.subscribed)
    room.on("data_received", watcher.heard)
    room.on("disconnected", watcher.left)
    await room.connect(seat["url"], seat["token"])
    try:
        yield watcher
    finally:
        await watcher.close()
        await room.disconnect()
