"""Cutting one picture into pieces of about one size. Pure."""

from __future__ import annotations

from typing import Final

MIN_PACKET_BYTES: Final = 32
"""The least that a payload may be held to; below it descriptors would be most of what is sent."""


def split_evenly(data: bytes, max_bytes: int) -> list[bytes]:
    """Cut into the fewest pieces of at most `max_bytes`, sizes differing by one byte at most.

    A small last packet costs the link a whole header and tells the estimator less. `max_bytes`
    is at least 1; no data, no pieces.
    """
    count = -(-len(data) // max_bytes)
    if count <= 1:
        return [data] if data else []
    size, larger = divmod(len(data), count)
    cut = larger * (size + 1)
    return [data[at : at + size + 1] for at in range(0, cut, size + 1)] + [
        data[at : at + size] for at in range(cut, len(data), size)
    ]
