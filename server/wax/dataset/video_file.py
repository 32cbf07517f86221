"""Writes the pictures of an episode to an MP4 file with a constant rate: frame n is at n / fps.

All methods may raise `OSError` or `av.FFmpegError`.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Final

import av

if TYPE_CHECKING:
    from pathlib import Path

    from av.packet import Packet
    from av.video.frame import VideoFrame
    from av.video.stream import VideoStream

    from wax.dataset.statistics import PictureStatistics

CODEC: Final = "h264"
_ENCODER: Final = "libx264"
_OPTIONS: Final = {"preset": "ultrafast", "crf": "23"}
"""16 ms for a noisy picture of 1280×720; the next slower preset takes 25."""
_MP4: Final = {"movflags": "faststart"}
_KEYFRAME_EVERY: Final = 10
"""Frames: trainers read them in any order, and each costs all since its keyframe."""


class VideoFile:
    """Encodes pictures with H.264."""

    def __init__(self, path: Path, *, fps: int, size: tuple[int, int]) -> None:
        self._fps = fps
        self._container = av.open(str(path), "w", format="mp4", options=_MP4)
        self._stream = self._container.add_stream(_ENCODER, rate=fps, options=_OPTIONS)
        self._stream.width, self._stream.height = size
        self._stream.pix_fmt = "yuv420p"
        self._stream.gop_size = _KEYFRAME_EVERY
        self._stream.max_b_frames = 0
        self._time_base = Fraction(1, fps)
        self._frames = 0

    def add(self, frame: VideoFrame, statistics: PictureStatistics) -> None:
        """Add a picture, which may be the previous one; one a second counts."""
        if self._frames % self._fps == 0:
            statistics.add(frame)
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


class CopiedVideo:
    """Copies pictures that are H.264 already, the first of which is a keyframe.

    `like` is a file with such pictures.
    """

    def __init__(self, path: Path, *, fps: int, like: Path) -> None:
        self._container = av.open(str(path), "w", format="mp4", options=_MP4)
        with av.open(str(like), "r") as media:
            template = media.streams.video[0]
            self._stream = self._container.add_stream_from_template(template, opaque=True)
        self._time_base = Fraction(1, fps)
        self._stream.time_base = self._time_base
        self._frames = 0

    def add(self, packet: Packet[VideoStream], statistics: PictureStatistics) -> None:
        """Add the next picture; keyframes count."""
        if packet.is_keyframe:
            for frame in packet.decode():
                statistics.add(frame)
        packet.stream = self._stream
        packet.pts = packet.dts = self._frames
        packet.duration, packet.time_base = 1, self._time_base
        self._frames += 1
        self._container.mux_one(packet)

    def close(self) -> None:
        """Finish the file."""
        self._container.close()
