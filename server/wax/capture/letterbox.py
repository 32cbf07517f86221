"""Fit a picture of any size and shape into another, with black bars."""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np

from wax.capture.colour import to_i420

if TYPE_CHECKING:
    from av.video.frame import VideoFrame
    from numpy.typing import NDArray


def fit_frame(
    frame: VideoFrame, width: int, height: int, *, pixel_aspect: float = 1.0
) -> NDArray[np.uint8]:
    """Return a decoded frame as I420 of ``(height * 3 // 2, width)``, upright and in proportion.

    `width` and `height` are even. `pixel_aspect` is a pixel's width divided by its height. The
    frame's rotation (as phones store it) is undone, rounded to quarter turns.
    """
    quarters = round(frame.rotation / 90) % 4
    shown_width, shown_height = frame.width * pixel_aspect, float(frame.height)
    if quarters % 2:
        shown_width, shown_height = shown_height, shown_width
    inner_width, inner_height = inner_size(shown_width, shown_height, width, height)
    scaled_size = (inner_height, inner_width) if quarters % 2 else (inner_width, inner_height)
    i420 = to_i420(frame, *scaled_size)
    if quarters == 0 and (inner_width, inner_height) == (width, height):
        return i420
    canvas = black(width, height)
    for plane, target in zip(planes(i420), planes(canvas), strict=True):
        turned = np.rot90(plane, quarters)
        top = (target.shape[0] - turned.shape[0]) // 2
        left = (target.shape[1] - turned.shape[1]) // 2
        target[top : top + turned.shape[0], left : left + turned.shape[1]] = turned
    return canvas


def fit_bgr(bgr: NDArray[np.uint8], width: int, height: int) -> NDArray[np.uint8]:
    """Return an OpenCV image scaled in proportion into ``(height, width, 3)``, with black bars."""
    if bgr.shape[:2] == (height, width):
        return bgr
    inner_width, inner_height = inner_size(bgr.shape[1], bgr.shape[0], width, height)
    canvas = np.zeros((height, width, 3), np.uint8)
    top, left = (height - inner_height) // 2, (width - inner_width) // 2
    canvas[top : top + inner_height, left : left + inner_width] = cv2.resize(
        bgr, (inner_width, inner_height), interpolation=cv2.INTER_AREA
    )
    return canvas


def inner_size(shown_width: float, shown_height: float, width: int, height: int) -> tuple[int, int]:
    """Return the largest even size with the given proportions that fits into width × height."""
    scale = min(width / shown_width, height / shown_height)
    inner_width = min(width, max(2, round(shown_width * scale / 2) * 2))
    inner_height = min(height, max(2, round(shown_height * scale / 2) * 2))
    return inner_width, inner_height


def black(width: int, height: int) -> NDArray[np.uint8]:
    """Return a black I420 picture of even size."""
    i420 = np.full((height * 3 // 2, width), 128, np.uint8)
    i420[:height] = 16
    return i420


def planes(
    i420: NDArray[np.uint8],
) -> tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.uint8]]:
    """Return views of the luma and the two chroma planes of a contiguous I420 array."""
    height, width = i420.shape[0] * 2 // 3, i420.shape[1]
    chroma = i420[height:].reshape(2, height // 2, width // 2)
    return i420[:height], chroma[0], chroma[1]
