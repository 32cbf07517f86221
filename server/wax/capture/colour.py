"""Finds out the colour space of a decoded picture and converts it to the one that WAX uses.

That one is BT.601 in limited range (black 16, white 235): what VP8 carries without saying so, and
what our H.264 says that it carries (`wax.encode.video_encoder`).
"""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any, Final

import cv2
import numpy as np
from av.video.frame import VideoFrame
from av.video.reformatter import ColorRange, Colorspace, VideoReformatter

from wax.capture.high_range import HLG, PQ, to_sdr

if TYPE_CHECKING:
    from numpy.typing import NDArray

_DECLARED: Final = {
    1: Colorspace.ITU709,
    4: Colorspace.FCC,
    5: Colorspace.ITU601,
    6: Colorspace.ITU601,
    7: Colorspace.SMPTE240M,
    9: Colorspace.BT2020,
    10: Colorspace.BT2020,
}
"""Those matrices of ITU-T H.273, table 4, that libswscale knows; RGB needs none."""

_SD_LINES: Final = 576
_SD_COLUMNS: Final = 1024
"""A larger picture that does not declare its matrix is BT.709, as every player assumes."""

_RAW_GREY: Final = frozenset({"gray", "gray10le", "gray10be", "gray12le", "gray12be"})
"""Formats that monochrome HEVC and AV1 decode to; libswscale assumes that they are full range."""


def to_i420(frame: VideoFrame, width: int, height: int) -> NDArray[np.uint8]:
    """Return a decoded frame scaled to this even size, as ``(height * 3 // 2, width)``.

    What the frame declares is honoured. Otherwise its format decides: full range for JPEG and RGB,
    limited range for all other video. Transparent pixels become black.
    """
    if frame.format.components[-1].is_alpha or frame.format.name == "pal8":
        frame = _on_black(frame)
    if frame.format.name in _RAW_GREY and frame.color_range == ColorRange.MPEG:
        grey = _scaled(frame, width, height, format="gray").to_ndarray()
        return np.concatenate([grey, np.full((height // 2, width), 128, np.uint8)])
    declared = {"src_colorspace": _matrix(frame), "src_color_range": _range(frame)}
    if frame.color_trc in (PQ, HLG):
        deep = _scaled(frame, width, height, format="rgb48le", **declared)
        rgb = to_sdr(np.asarray(deep.to_ndarray(), np.uint16), frame.color_trc)
        return np.asarray(cv2.cvtColor(rgb, cv2.COLOR_RGB2YUV_I420), np.uint8)
    scaled = _scaled(
        frame,
        width,
        height,
        format="yuv420p",
        dst_colorspace=Colorspace.ITU601,
        dst_color_range=ColorRange.MPEG,
        **declared,
    )
    return np.asarray(scaled.to_ndarray(), np.uint8)


class _Kept(threading.local):
    """Each thread's libswscale: a frame's own prepares its tables anew, in up to 6 ms."""

    def __init__(self) -> None:
        self.reformatter = VideoReformatter()


_kept: Final = _Kept()


def _scaled(frame: VideoFrame, width: int, height: int, **colours: Any) -> VideoFrame:
    # Starting threads for one picture costs more than they gain.
    return _kept.reformatter.reformat(
        frame, width, height, interpolation="AREA", threads=1, **colours
    )


def _matrix(frame: VideoFrame) -> Colorspace:
    """Return the matrix of a frame's YUV."""
    if frame.colorspace in _DECLARED:
        return _DECLARED[frame.colorspace]
    short, long = sorted((frame.width, frame.height))
    is_sd = short <= _SD_LINES and long <= _SD_COLUMNS
    return Colorspace.ITU601 if is_sd or _is_jpeg(frame) else Colorspace.ITU709


def _range(frame: VideoFrame) -> ColorRange:
    if frame.color_range in (ColorRange.MPEG, ColorRange.JPEG):
        return ColorRange(frame.color_range)
    return ColorRange.JPEG if _is_jpeg(frame) else ColorRange.MPEG


def _is_jpeg(frame: VideoFrame) -> bool:
    """Return whether FFmpeg's pixel format itself stands for JPEG."""
    return frame.format.name.startswith("yuvj")


def _on_black(frame: VideoFrame) -> VideoFrame:
    rgba = frame.reformat(
        format="rgba", src_colorspace=_matrix(frame), src_color_range=_range(frame)
    ).to_ndarray()
    opaque = rgba[..., 3]
    if (opaque == 255).all():
        return frame
    rgb = (rgba[..., :3].astype(np.uint16) * opaque[..., None] // 255).astype(np.uint8)
    return VideoFrame.from_ndarray(rgb, "rgb24")
