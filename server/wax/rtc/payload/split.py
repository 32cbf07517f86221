"""Splits one picture into pieces of about one size. Pure."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

MIN_PACKET_BYTES: Final = 32
"""The smallest payload limit; below it descriptors would dominate."""


Payload = tuple[bytes, bytes]
"""A payload: one viewer's own header, and a piece of the picture that all viewers share."""

_CUT: Final = 64
"""How many split pictures are cached for the next viewer: a few renditions, split in a few ways."""


@lru_cache(_CUT)
def split_evenly(data: bytes, max_bytes: int, first_less: int = 0) -> tuple[bytes, ...]:
    """Split into the fewest pieces of at most `max_bytes`, all of one size but the first and last.

    The first is shorter by `first_less`, which makes room for its longer header; the last is
    shorter by less than a byte per piece. Packets of one size leave in one call; a small last one
    would cost a whole header, and tell the estimator less. `max_bytes` is at least twice
    `first_less`, and 1; empty data gives no pieces. Equal arguments return the cached pieces.
    """
    whole = len(data) + first_less
    count = -(-whole // max_bytes)
    if count <= 1 or not data:
        return (data,) if data else ()
    size = -(-whole // count)
    first = size - first_less
    return data[:first], *(data[at : at + size] for at in range(first, len(data), size))
