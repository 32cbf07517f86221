"""Turn and mirror the picture of a camera that is mounted at an angle or looks into a mirror.

This happens before anything else uses the picture: the time and the path that are drawn on it,
recordings and renditions are all upright.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import cv2
import numpy as np

from wax.capture.letterbox import planes

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from wax.capture.source import Picture, VideoSource
    from wax.config.video import VideoSettings

_FLIP: Final = {(True, True): -1, (True, False): 1, (False, True): 0}
"""OpenCV's flip code for (left and right, up and down)."""


def upright(source: VideoSource, settings: VideoSettings) -> VideoSource:
    """Wrap the source as the settings turn it; return it unchanged if it needs no turning."""
    if not settings.is_turned or getattr(source, "is_upright", False):
        return source
    return Upright(source, settings.rotate // 90, mirror=settings.mirror)


class Upright:
    """A source whose pictures are turned clockwise by quarters and then mirrored."""

    def __init__(self, source: VideoSource, quarters: int, *, mirror: bool) -> None:
        self._source = source
        self._quarters = quarters
        self._mirror = mirror

    @property
    def name(self) -> str:
        return str(getattr(self._source, "name", "of the robot"))

    @property
    def rest_s(self) -> float | None:
        return getattr(self._source, "rest_s", None)

    def catch_up(self) -> None:
        if hasattr(self._source, "catch_up"):
            self._source.catch_up()

    def open(self) -> None:
        self._source.open()

    def read(self) -> Picture:
        picture = self._source.read()
        return replace(picture, i420=turned(picture.i420, self._quarters, mirror=self._mirror))

    def close(self) -> None:
        self._source.close()


def turned(i420: NDArray[np.uint8], quarters: int, *, mirror: bool = False) -> NDArray[np.uint8]:
    """Return a planar picture turned clockwise by quarters, then mirrored left to right."""
    height, width = i420.shape[0] * 2 // 3, i420.shape[1]
    if quarters % 2:
        height, width = width, height
    result = np.empty((height * 3 // 2, width), np.uint8)
    for plane, target in zip(planes(np.ascontiguousarray(i420)), planes(result), strict=True):
        turn_plane(plane, target, quarters, mirror=mirror)
    return result


def turn_plane(
    plane: NDArray[np.uint8], target: NDArray[np.uint8], quarters: int, *, mirror: bool
) -> None:
    """Write a plane into `target`, turned as `turned` does it."""
    # A quarter turn is a transposition and a flip; a half turn or a mirror only changes the flip.
    # Nothing is allocated, because fresh pages of memory cost more than the turning.
    source = cv2.transpose(plane, dst=target) if quarters % 2 else plane
    flips = (quarters % 4 in (1, 2)) != mirror, quarters % 4 in (2, 3)
    if any(flips):
        cv2.flip(source, _FLIP[flips], dst=target)
    elif source is plane:
        np.copyto(target, plane)
