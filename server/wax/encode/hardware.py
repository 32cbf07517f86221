"""Hardware H.264 encoders through PyAV: the candidates, and an encoder for one rendition."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import av
from av.codec.codec import UnknownCodecError
from av.error import FFmpegError
from av.video.frame import PictureType
from av.video.reformatter import VideoReformatter

from wax.encode.encoded import VIDEO_RATE_HZ, VIDEO_TIME_BASE, EncodedPicture
from wax.encode.parameter_sets import ParameterSets
from wax.encode.video_encoder import context_for, frame_of
from wax.errors import reason_of

if TYPE_CHECKING:
    from wax.capture.source import Picture
    from wax.config.video import RenditionSettings

_ERROR: Final = av.logging.ERROR
_GOP: Final = 30_000
"""Practically no automatic keyframes; Intel's encoders store it in 16 bits."""


class HardwareError(Exception):
    """The encoder violates a requirement, which the text names."""


@dataclass(frozen=True, slots=True)
class Hardware:
    """An encoder by FFmpeg's name, with its pixel format and options.

    The options make it return each picture before it accepts the next, in constrained baseline, and
    make a requested keyframe an IDR picture, with which a decoder can start.
    """

    name: str
    pixels: str
    options: dict[str, str] = field(default_factory=dict)


HARDWARE: Final = (
    Hardware(
        "h264_nvenc",
        "yuv420p",
        {
            "preset": "p2",
            "tune": "ull",
            "zerolatency": "1",
            "delay": "0",
            "rc": "cbr",
            "profile": "baseline",
            "forced-idr": "1",
        },
    ),
    Hardware(
        "h264_qsv",
        "nv12",
        {
            "preset": "veryfast",
            "async_depth": "1",
            "look_ahead": "0",
            "low_delay_brc": "1",
            "profile": "baseline",
            "forced_idr": "1",
        },
    ),
    Hardware(
        "h264_amf",
        "yuv420p",
        {
            "usage": "ultralowlatency",
            "quality": "speed",
            "rc": "cbr",
            "async_depth": "1",
            "profile": "constrained_baseline",
            "forced_idr": "1",
        },
    ),
    Hardware(
        "h264_v4l2m2m",
        "yuv420p",
        {"num_output_buffers": "4", "num_capture_buffers": "4"},
    ),
)
"""All candidates, the fastest first; the last is that of a Raspberry Pi up to the 4."""


def is_built_in(name: str) -> bool:
    """Return whether PyAV's FFmpeg includes it; only a trial shows whether this machine has it."""
    try:
        av.codec.Codec(name, "w")
    except UnknownCodecError:
        return False
    return True


class HardwareEncoder:
    """Encodes one rendition; raises `HardwareError` if the encoder violates a requirement.

    Not thread-safe. The encoder may also produce keyframes without a request; FFmpeg's flag counts.
    """

    def __init__(self, hardware: Hardware, rendition: RenditionSettings) -> None:
        self._rendition = rendition
        self._pixels = hardware.pixels
        self._reformatter = VideoReformatter()
        self._context = _open(hardware, rendition)
        self._sets = ParameterSets(self._context.extradata or b"")
        self._newest_pts = -1
        self._is_fresh = True

    def encode(self, picture: Picture, *, keyframe: bool) -> EncodedPicture | None:
        """Encode one picture; None if its capture time is not newer than the previous one's."""
        pts = round(picture.captured_s * VIDEO_RATE_HZ)
        if pts <= self._newest_pts:
            return None
        self._newest_pts = pts
        frame = self._reformatter.reformat(
            frame_of(picture, self._rendition), format=self._pixels, threads=1
        )
        frame.pts = pts
        frame.time_base = VIDEO_TIME_BASE
        frame.pict_type = PictureType.I if keyframe or self._is_fresh else PictureType.NONE
        try:
            packets = self._context.encode(frame)
        except (FFmpegError, OSError) as error:
            raise HardwareError(why(error)) from error
        if len(packets) != 1:
            raise HardwareError(f"it gives {len(packets)} packets for one picture")
        (packet,) = packets
        if packet.pts != pts:
            raise HardwareError("it gives another picture than it was given")
        if self._is_fresh and not packet.is_keyframe:
            raise HardwareError("its first picture is no keyframe")
        self._is_fresh = False
        data = self._sets.prepend_to(bytes(packet)) if packet.is_keyframe else bytes(packet)
        return EncodedPicture(
            data=data,
            pts=pts,
            rendition=self._rendition.name,
            keyframe=packet.is_keyframe,
            layer=0,
            captured_s=picture.captured_s,
        )


def why(error: Exception) -> str:
    """Return the error text of FFmpeg's encoder, or the error's own if there is none."""
    log = getattr(error, "log", None)
    told = log[2].strip().rstrip(".") if log else ""
    return told or reason_of(error)


def _open(hardware: Hardware, rendition: RenditionSettings) -> av.VideoCodecContext:
    """Open the encoder; if that fails, the reason is the first error that FFmpeg logs, if any."""
    with av.logging.Capture() as said:
        try:
            return _opened(hardware, rendition)
        except (FFmpegError, OSError, ValueError) as error:
            reasons = [text.strip().rstrip(".") for level, _, text in said if level <= _ERROR]
            raise HardwareError(next(iter(reasons), why(error))) from error


def _opened(hardware: Hardware, rendition: RenditionSettings) -> av.VideoCodecContext:
    context = context_for(hardware.name, rendition, hardware.pixels)
    context.gop_size = _GOP
    context.max_b_frames = 0
    context.profile = "Constrained Baseline"
    rate = str(rendition.bitrate_bps)
    # The rate buffer is half a second: on a slow link bursts are delay.
    steady = {"maxrate": rate, "bufsize": str(rendition.bitrate_bps // 2)}
    context.options = steady | hardware.options
    context.open()
    return context
