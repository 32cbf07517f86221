"""Reads an answer's body of bounded length, whatever the other server sends."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.cluster.errors import RoomError

if TYPE_CHECKING:
    import aiohttp


async def read_body(response: aiohttp.ClientResponse, most_bytes: int) -> bytes:
    """Return the whole body; raises `RoomError` if it is longer than `most_bytes`."""
    data = bytearray()
    while piece := await response.content.readany():
        data += piece
        if len(data) > most_bytes:
            raise RoomError(f"{response.url.origin()} answers with more than {most_bytes} bytes")
    return bytes(data)
