"""A client that sees what operators see and do, for a program that learns; it never drives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from aiortc.mediastreams import MediaStreamError

from wax.client.client import Client

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from av import VideoFrame


@dataclass(frozen=True, slots=True)
class ObservedPicture:
    """A picture, its capture in ms of the server's clock, and what the robot had been sent last.

    `driven` is the message `Driven` as a dictionary, empty before the first.
    """

    picture: VideoFrame
    captured_ms: float
    driven: dict[str, Any]


class Follower(Client):
    """Watches the driving view without sound. It has no way to drive, and needs no permission."""

    decodes = True

    def __init__(self, url: str, **options: Any) -> None:
        super().__init__(url, sound=False, **options)

    async def connect(self) -> None:
        await super().connect()
        self.send(type="follow")

    async def watch(self) -> AsyncIterator[ObservedPicture]:
        """Yield the newest picture again and again, until the connection ends.

        Pictures that arrive while the caller is busy are dropped.
        """
        while True:
            try:
                rtp, picture = await self.media.picture()
            except MediaStreamError:
                return
            captured_ms = self.captured_ms("video", rtp)
            if captured_ms is not None:
                yield ObservedPicture(picture, captured_ms, self.newest("driven"))
