"""Writes the pictures of an episode to an MP4 file with a constant rate."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Final

import av

if TYPE_CHECKING:
    from pathlib import Path

    from av.video.frame import VideoFrame

CODEC: Final = "h264"
_ENCODER: Final = "libx264"
_OPTIONS: Final = {"preset": "superfast", "crf": "20", "x264-params": "scenecut=0"}
_KEYFRAME_EVERY: Final = 10
"""Frames: trainers read them in any order, and each costs all since its keyframe."""


class VideoFile:
    """Encodes pictures with H.264; frame n is at n / `fps`.

    All methods may raise `OSError` or `av.FFmpegError`.
    """

    def __init__(self, path: Path, *, fps: int, size: tuple[int, int]) -> None:
        self._container = av.open(str(path), "w", format="mp4", options={"movflags": "faststart"})
        self._stream = self._container.add_stream(_ENCODER, rate=fps, options=_OPTIONS)
        self._stream.width, self._stream.height = size
        self._stream.pix_fmt = "yuv420p"
        self._stream.gop_size = _KEYFRAME_EVERY
        self._stream.max_b_frames = 0
        self._time_base = Fraction(1, fps)
        self._frames = 0

    def add(self, frame: VideoFrame) -> None:
        """Add a picture, which may be the previous one."""
        frame.pts, frame.time_base = self._frames, self._time_base
        frame.pict_type = av.video.frame.PictureType.NONE
        self._frames += 1
        self._container.mux(self._stream.encode(frame))

    def close(self) -> None:
        """Finish the file."""
        try:
            self._container.mux(self._stream.encode(None))
        finally:
            self._container.close()
