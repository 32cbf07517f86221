"""Converts ROS 2's raw and compressed pictures to OpenCV's BGR (pure)."""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING, Any, Final

import cv2
import numpy as np

from wax.robot.ros2 import members

if TYPE_CHECKING:
    from numpy.typing import NDArray

MAX_PIXELS: Final = 4096 * 4096
_ENCODINGS: Final = {
    "bgr8": (3, None),
    "rgb8": (3, cv2.COLOR_RGB2BGR),
    "bgra8": (4, cv2.COLOR_BGRA2BGR),
    "rgba8": (4, cv2.COLOR_RGBA2BGR),
    "mono8": (1, cv2.COLOR_GRAY2BGR),
    "8UC1": (1, cv2.COLOR_GRAY2BGR),
    "8UC3": (3, None),
    "mono16": (2, cv2.COLOR_GRAY2BGR),
    "16UC1": (2, cv2.COLOR_GRAY2BGR),
    "bayer_rggb8": (1, cv2.COLOR_BayerRGGB2BGR),
    "bayer_bggr8": (1, cv2.COLOR_BayerBGGR2BGR),
    "bayer_gbrg8": (1, cv2.COLOR_BayerGBRG2BGR),
    "bayer_grbg8": (1, cv2.COLOR_BayerGRBG2BGR),
    "yuv422": (2, cv2.COLOR_YUV2BGR_UYVY),
    "uyvy": (2, cv2.COLOR_YUV2BGR_UYVY),
    "yuv422_yuy2": (2, cv2.COLOR_YUV2BGR_YUYV),
    "yuyv": (2, cv2.COLOR_YUV2BGR_YUYV),
}
"""Octets per pixel, and OpenCV's code for conversion to BGR. YUV is BT.601 in limited range.

Alpha is ignored: simulators leave it at any value.
"""
_DEEP: Final = frozenset({"mono16", "16UC1"})
_MAX_WORDS: Final = 40


def to_bgr(message: Any) -> NDArray[np.uint8]:
    """Return the picture of an Image or CompressedImage; raises `ValueError` with its encoding."""
    try:
        data = _octets(message.data)
        if hasattr(message, "encoding"):
            return _raw(message, data)
        return _compressed(getattr(message, "format", ""), data)
    except (AttributeError, TypeError, OverflowError, cv2.error) as error:
        raise ValueError("no picture") from error


def _octets(data: Any) -> NDArray[np.uint8]:
    """Return the octets, which JSON has in base64 or, from some bridges, as a list of numbers."""
    if isinstance(data, str):
        data = base64.b64decode(data)
    return np.frombuffer(bytes(data) if isinstance(data, list) else data, np.uint8)


def _raw(message: Any, data: NDArray[np.uint8]) -> NDArray[np.uint8]:
    encoding = members.text(message.encoding)[:_MAX_WORDS]
    height, width = members.whole(message.height), members.whole(message.width)
    if encoding not in _ENCODINGS:
        raise ValueError(encoding)
    size, conversion = _ENCODINGS[encoding]
    # Some leave the step 0; then rows are contiguous if the data fill the picture.
    is_tight = not getattr(message, "step", None) and data.size == height * width * size
    step = width * size if is_tight else members.whole(message.step)
    is_whole = 0 < width * size <= step and height > 0 and data.size >= height * step
    if not is_whole or width * height > MAX_PIXELS or step > MAX_PIXELS:
        raise ValueError(f"{encoding}, {width}×{height}, {data.size} octets")
    rows = data[: height * step].reshape(height, step)[:, : width * size]
    pixels = np.ascontiguousarray(rows).reshape(height, width, size)
    if encoding in _DEEP:  # the more significant octet
        pixels = np.ascontiguousarray(pixels[:, :, 0 if message.is_bigendian else 1])
    return pixels if conversion is None else np.asarray(cv2.cvtColor(pixels, conversion), np.uint8)


def _compressed(stated: object, data: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Decode by the format that the octets themselves show; `stated` is only for the message."""
    bgr = cv2.imdecode(data, cv2.IMREAD_COLOR) if data.size else None
    if bgr is None:
        raise ValueError((stated if isinstance(stated, str) else "")[:_MAX_WORDS] or "no picture")
    return np.asarray(bgr, np.uint8)
