"""Lists a V4L2 camera's modes: the sizes that it delivers, each with its highest rate.

Calls and structures are those of linux/videodev2.h.
"""

from __future__ import annotations

import contextlib
import struct
from typing import TYPE_CHECKING, Final, NamedTuple

from wax.capture.v4l2_controls import opened
from wax.errors import SourceError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from wax.capture.v4l2_controls import Ioctl

ENUM_FMT: Final = 0xC0405602
ENUM_FRAMESIZES: Final = 0xC02C564A
ENUM_FRAMEINTERVALS: Final = 0xC034564B
"""The request codes VIDIOC_…"""

FORMAT: Final = struct.Struct("=III32sII12x")
SIZE: Final = struct.Struct("=III6I8x")
INTERVAL: Final = struct.Struct("=IIIII6I8x")
"""v4l2_fmtdesc, v4l2_frmsizeenum and v4l2_frmivalenum."""

CAPTURE: Final = 1
DISCRETE: Final = 1
_READABLE: Final = frozenset(
    {b"MJPG", b"JPEG", b"YUYV", b"UYVY", b"NV12", b"NV21", b"YU12", b"YV12"}
)
"""The formats that OpenCV decodes."""
_MOST: Final = 100


class Mode(NamedTuple):
    """A size, and the most pictures a second that the camera delivers at it."""

    width: int
    height: int
    fps: float


def list_modes(camera: int | str, *, ioctl: Ioctl | None = None) -> list[Mode]:
    """Return the camera's modes; none if it is not there or does not tell."""
    best: dict[tuple[int, int], float] = {}
    with contextlib.suppress(OSError, SourceError), opened(camera, ioctl) as call:
        for pixels in _formats(call):
            for width, height in _sizes(call, pixels):
                fps = max(_rates(call, pixels, width, height), default=0.0)
                best[width, height] = max(fps, best.get((width, height), 0.0))
    return [Mode(*size, fps) for size, fps in best.items()]


def _formats(call: Callable[[int, bytearray], object]) -> Iterator[int]:
    for asked in _answers(call, ENUM_FMT, lambda index: FORMAT.pack(index, CAPTURE, 0, b"", 0, 0)):
        pixels: int = FORMAT.unpack(asked)[4]
        if pixels.to_bytes(4, "little") in _READABLE:
            yield pixels


def _sizes(call: Callable[[int, bytearray], object], pixels: int) -> Iterator[tuple[int, int]]:
    """Yield the sizes; of a range the largest, and those of it that most cameras have."""
    for asked in _answers(call, ENUM_FRAMESIZES, lambda i: SIZE.pack(i, pixels, 0, *[0] * 6)):
        _, _, kind, *values = SIZE.unpack(asked)
        if kind == DISCRETE:
            yield values[0], values[1]
            continue
        least_width, most_width, step_width, least_height, most_height, step_height = values
        for width, height in ((most_width, most_height), (1280, 720), (640, 480)):
            fits = least_width <= width <= most_width and least_height <= height <= most_height
            steps = (width - least_width, step_width), (height - least_height, step_height)
            if fits and not any(beyond % max(step, 1) for beyond, step in steps):
                yield width, height
        return  # a range has no further ones


def _rates(
    call: Callable[[int, bytearray], object], pixels: int, width: int, height: int
) -> Iterator[float]:
    """Yield pictures a second; of a range only the most, which is that of its first interval."""
    for asked in _answers(
        call, ENUM_FRAMEINTERVALS, lambda i: INTERVAL.pack(i, pixels, width, height, 0, *[0] * 6)
    ):
        numerator, denominator = INTERVAL.unpack(asked)[5:7]
        if numerator:
            yield denominator / numerator
        if INTERVAL.unpack(asked)[4] != DISCRETE:
            return


def _answers(
    call: Callable[[int, bytearray], object], request: int, packed: Callable[[int], bytes]
) -> Iterator[bytearray]:
    """Yield the answers for each index until the driver has no more."""
    for index in range(_MOST):
        asked = bytearray(packed(index))
        try:
            call(request, asked)
        except OSError:
            return
        yield asked
