"""A picture whose four quarters differ in colour."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.capture.letterbox import black, planes
from wax.capture.source import Picture

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Corners = list[tuple[int, ...]]

CORNERS: Final[Corners] = [(210, 100, 90), (60, 170, 110), (150, 60, 180), (100, 128, 210)]
"""Luma and chroma of a picture's quarters: left and right above, left and right below."""


def quartered(width: int, height: int) -> Picture:
    i420 = black(width, height)
    for number, plane in enumerate(planes(i420)):
        middle, centre = plane.shape[0] // 2, plane.shape[1] // 2
        for at, corner in enumerate(CORNERS):
            rows = slice(middle) if at < 2 else slice(middle, None)
            plane[rows, slice(centre) if at % 2 == 0 else slice(centre, None)] = corner[number]
    return Picture(i420, 5000.0)


def corners(i420: NDArray[np.uint8]) -> Corners:
    """Return what each quarter has where no time is written."""
    found = []
    for down in (0.25, 0.625):
        for along in (0.25, 0.75):
            middle = [
                plane[int(down * plane.shape[0]), int(along * plane.shape[1])]
                for plane in planes(i420)
            ]
            found.append(tuple(int(one) for one in middle))
    return found
