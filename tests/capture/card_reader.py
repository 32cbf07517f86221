"""Reads the time off a test card, as `wax.capture.testcard` describes it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.capture.source import Picture
from wax.capture.testcard import crc8

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

MIDDLE = 125.5
DECIDED = 36
"""A cell closer than this to mid-grey is not a test card's."""


def read_stamp(picture: Picture | NDArray[np.uint8]) -> int | None:
    """Read the Unix time in ms, modulo 2⁴⁰, from a test card; None if there is none.

    Takes a `Picture`, its I420 array ``(height * 3 // 2, width)``, or a luma plane ``(height,
    width)`` of any size from 64×60; it tries both layouts. All black gives None, not time 0.
    """
    if isinstance(picture, Picture):
        return _read(picture.i420[: picture.height])
    stamp = _read(picture)
    if stamp is None and picture.shape[0] % 3 == 0:
        stamp = _read(picture[: picture.shape[0] * 2 // 3])
    return stamp


def _read(luma: NDArray[np.uint8]) -> int | None:
    height, width = luma.shape
    if width < 64 or height < 60:
        return None
    bits = 0
    for row in range(3):
        for column in range(16):
            # The inner half of the cell: its edges are blurred by scaling and by the codec.
            top, bottom = ((4 * row + n) * height // 60 for n in (1, 3))
            left, right = ((4 * column + n) * width // 64 for n in (1, 3))
            grey = float(luma[top : max(bottom, top + 1), left : max(right, left + 1)].mean())
            if abs(grey - MIDDLE) < DECIDED:
                return None
            bits = bits << 1 | (grey > MIDDLE)
    stamp = bits >> 8
    if stamp == 0 or crc8(stamp.to_bytes(5, "big")) != bits & 0xFF:
        return None
    return stamp
