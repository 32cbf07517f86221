"""Cutting one picture into pieces of about one size. Pure."""

from __future__ import annotations

from typing import Final

MIN_PACKET_BYTES: Final = 32
"""The smallest payload limit; below it descriptors would dominate."""


def split_evenly(data: bytes, max_bytes: int) -> list[bytes]:
    """Cut into the fewest pieces of at most `max_bytes`, sizes differing by one byte at most.

    A small last packet costs a whole header and tells the estimator less. `max_bytes` is at least
    1; no data gives no pieces.
    """
    count = -(-len(data) // max_bytes)
    if count <= 1:
        return [data] if data else []
    size, larger = divmod(len(data), count)
    cut = larger * (size + 1)
    return [data[at : at + size + 1] for at in range(0, cut, size + 1)] + [
        data[at : at + size] for at in range(cut, len(data), size)
    ]
