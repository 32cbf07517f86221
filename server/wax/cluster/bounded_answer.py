"""The body of an answer, of which another server does not decide how long it is."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.cluster.errors import RoomError

if TYPE_CHECKING:
    import aiohttp


async def whole(response: aiohttp.ClientResponse, most_bytes: int) -> bytes:
    """Return all of it, in however many pieces it comes; raises `RoomError` if it is longer."""
    data = bytearray()
    while piece := await response.content.readany():
        data += piece
        if len(data) > most_bytes:
            raise RoomError(f"{response.url.origin()} answers with more than {most_bytes} bytes")
    return bytes(data)
