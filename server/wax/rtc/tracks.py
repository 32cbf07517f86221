"""Lanes as tracks: aiortc asks for the next packet, the lane gives it when there is one.

A track belongs to one peer and is stopped with it. Returning packets instead of frames is what
lets one encoder serve everybody.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, Protocol

from aiortc import MediaStreamTrack

if TYPE_CHECKING:
    from collections.abc import Callable

    from av.packet import Packet


class Encoded(Protocol):
    """A packet and the moment its content was captured, on the server's clock."""

    @property
    def packet(self) -> Packet[Any]: ...

    @property
    def captured_s(self) -> float: ...


class Lane(Protocol):
    """Where the packets come from."""

    async def get(self) -> Encoded: ...


class LaneTrack(MediaStreamTrack):
    """Hands one lane's packets to one sender.

    `on_sent` is called with each packet once it has left, before the next one is fetched.
    """

    def __init__(
        self, *, kind: Literal["audio", "video"], lane: Lane, on_sent: Callable[[Encoded], None]
    ) -> None:
        self.kind = kind
        super().__init__()
        self._lane = lane
        self._on_sent = on_sent
        self._last: Encoded | None = None

    async def recv(self) -> Packet[Any]:
        if self._last is not None:
            self._on_sent(self._last)
        self._last = await self._lane.get()
        return self._last.packet
