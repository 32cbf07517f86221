"""Cutting one picture into pieces of about one size. Pure."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

MIN_PACKET_BYTES: Final = 32
"""The smallest payload limit; below it descriptors would dominate."""


Payload = tuple[bytes, bytes]
"""A payload: a head that is one viewer's, and a piece of the picture, which all of them share."""

_CUT: Final = 64
"""How many pictures' pieces are kept for the next viewer: a few renditions, cut in a few ways."""


@lru_cache(_CUT)
def split_evenly(data: bytes, max_bytes: int, first_less: int = 0) -> tuple[bytes, ...]:
    """Cut into the fewest pieces of at most `max_bytes`, all of one size but the ends.

    The first is shorter by `first_less`, for what its header has more; the last takes what is left,
    by less than a byte a piece. Packets of one size leave in one call; a small last one would cost
    a whole header, and tell the estimator less. `max_bytes` is at least twice `first_less`, and 1;
    no data gives no pieces. The same pieces are given again to whoever cuts the same.
    """
    whole = len(data) + first_less
    count = -(-whole // max_bytes)
    if count <= 1 or not data:
        return (data,) if data else ()
    size = -(-whole // count)
    first = size - first_less
    return data[:first], *(data[at : at + size] for at in range(first, len(data), size))
