"""Somebody who watches in a room by LiveKit's own SDK."""

from __future__ import annotations

import asyncio
import json
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any, Self

from livekit import rtc

from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Mapping


class Watcher:
    """Counts what comes: pictures by the robot's rendition, sound that is not silence."""

    def __init__(self) -> None:
        self.pictures: dict[str, set[tuple[int, int]]] = {}
        self.is_out = False
        self._loud = 0
        self._told: list[dict[str, Any]] = []
        self._room = rtc.Room()
        self._reading: list[asyncio.Task[None]] = []

    async def connect(self, seat: Mapping[str, str]) -> Self:
        """Enter the room of a seat; raises `rtc.ConnectError` where LiveKit refuses."""
        self._room.on("track_subscribed", self._subscribed)
        self._room.on("data_received", lambda packet: self._told.append(json.loads(packet.data)))
        self._room.on("disconnected", self._left)
        await self._room.connect(seat["url"], seat["token"])
        return self

    async def watches(self) -> None:
        """Wait until both renditions and the sound have come."""

        async def both() -> bool:
            return len(self.pictures) == 2 and self._loud > 10

        await eventually(both, "two renditions and the sound come", within_s=15)

    async def hears_news(self) -> dict[str, Any]:
        """Wait for the second news of the robot's room."""

        async def told() -> list[dict[str, Any]]:
            return self._told[1:]

        return (await eventually(told, "the state comes"))[-1]

    async def leaves(self) -> None:
        """Wait until it has been taken out."""

        async def is_out() -> bool:
            return self.is_out

        await eventually(is_out, "it is taken out of the room")

    async def close(self) -> None:
        for task in self._reading:
            task.cancel()
        await asyncio.gather(*self._reading, return_exceptions=True)
        await self._room.disconnect()

    def _subscribed(
        self, track: Any, publication: rtc.RemoteTrackPublication, robot: rtc.RemoteParticipant
    ) -> None:
        is_video = publication.kind == rtc.TrackKind.KIND_VIDEO
        read = self._see(track, robot.identity) if is_video else self._hear(track)
        self._reading.append(asyncio.create_task(read))

    def _left(self, reason: object) -> None:
        self.is_out = True

    async def _see(self, track: rtc.Track, who: str) -> None:
        async for event in rtc.VideoStream(track):
            size = (event.frame.width, event.frame.height)
            self.pictures.setdefault(who, set()).add(size)

    async def _hear(self, track: rtc.Track) -> None:
        async for event in rtc.AudioStream(track):
            self._loud += any(event.frame.data)


@asynccontextmanager
async def watching(seat: Mapping[str, str]) -> AsyncIterator[Watcher]:
    """Watch inside the block."""
    watcher = Watcher()
    try:
        yield await watcher.connect(seat)
    finally:
        await watcher.close()
