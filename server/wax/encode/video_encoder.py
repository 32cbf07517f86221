"""One rendition's encoder: pictures in, packets with their temporal layer out."""

from __future__ import annotations

import time
from fractions import Fraction
from typing import TYPE_CHECKING, Final, Literal, Protocol

import av
import cv2
import numpy as np
from av.video.frame import PictureType, VideoFrame
from av.video.reformatter import ColorRange, Colorspace

from wax.capture.letterbox import planes
from wax.encode.effort import Effort
from wax.encode.encoded import VIDEO_RATE_HZ, VIDEO_TIME_BASE, EncodedPicture

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from wax.capture.source import Picture
    from wax.config.video import RenditionSettings

_VP8_LAYERS: Final = (0, 2, 1, 2)
"""The temporal layer of each picture after a keyframe: 1/4, 1/2 and all of the frame rate."""

_VP8_SYNC: Final = (False, True, True, False)
"""Which of them depend only on layer 0: the last one also uses layer 1."""

_NEVER: Final = 100_000
"""No automatic keyframes: they would restart the layers unnoticed."""

_VP8_REALTIME: Final = {
    "deadline": "realtime",
    "cpu-used": "-6",
    "lag-in-frames": "0",
    "error-resilient": "1",
    "noise-sensitivity": "0",
    "static-thresh": "1",
}

_VP8_HURRIED: Final = {"cpu-used": "-12"}
"""For 1280×720 half the time where everything moves, for 0.005 of SSIM there and in a room."""

_VP8_SMALL: Final = {"deadline": "good", "cpu-used": "2"}
"""For small pictures, where a thorough search is cheap: at 16 kbit/s the fast one produces twice
the target rate, too much for a modem."""

_SMALL_PIXELS_PER_S: Final = 300_000
"""160×120 at 15 a second, at 3 ms a picture."""

_LEVEL_31_MACROBLOCKS: Final = 3600
_LEVEL_31_MACROBLOCKS_PER_S: Final = 108_000
_LEVEL_31_BITRATE_BPS: Final = 14_000_000
"""1280×720 at 30 a second, which every browser decodes (H.264, table A-1; RFC 7742, 6.2)."""


class PictureEncoder(Protocol):
    """Encodes each picture as one packet; called from one thread."""

    def encode(self, picture: Picture, *, keyframe: bool) -> EncodedPicture | None: ...


class VideoEncoder:
    """Encodes one rendition with VP8 in three temporal layers or H.264 constrained baseline.

    Not thread-safe. Keyframes are made on request, and where the effort is lowered (`Effort`).
    """

    def __init__(
        self,
        *,
        codec: Literal["vp8", "h264"],
        rendition: RenditionSettings,
        now_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._rendition = rendition
        self._layers = _VP8_LAYERS if codec == "vp8" else (0,)
        self._make = _vp8 if codec == "vp8" else _h264
        self._context = self._make(rendition, is_hurried=False)
        self._effort = Effort(rendition.fps)
        self._now_s = now_s
        self._since_keyframe = 0
        self._newest_pts = -1
        self._interval = round(VIDEO_RATE_HZ / rendition.fps)
        self._coded_pts = 0
        self._fresh = True

    def encode(self, picture: Picture, *, keyframe: bool) -> EncodedPicture | None:
        """Encode one picture; None if its capture time is not newer than the previous one's."""
        pts = round(picture.captured_s * VIDEO_RATE_HZ)
        if pts <= self._newest_pts:
            return None
        interval, self._newest_pts = pts - self._newest_pts, pts
        if self._effort.changes(keyframe=keyframe):
            self._context = self._make(self._rendition, is_hurried=self._effort.is_hurried)
            self._fresh = True
        keyframe = keyframe or self._fresh
        kind = PictureType.I if keyframe else PictureType.NONE
        # A picture may take the bits of its whole interval: after a pause, a keyframe would be ten
        # times as large, and stop the pictures of a slow link for seconds.
        self._interval = min(interval, self._interval) if keyframe else interval
        self._coded_pts += self._interval
        began_s = self._now_s()
        data = _encode(self._context, self._rendition, picture, self._coded_pts, kind)
        if not keyframe:
            self._effort.took(self._now_s() - began_s)
        if not data:
            return None
        self._fresh = False
        self._since_keyframe = 0 if keyframe else self._since_keyframe + 1
        place = self._since_keyframe % len(self._layers)
        layer = self._layers[place]
        return EncodedPicture(
            data=data,
            pts=pts,
            rendition=self._rendition.name,
            keyframe=keyframe,
            layer=layer,
            captured_s=picture.captured_s,
            sync=layer > 0 and _VP8_SYNC[place],
            droppable=layer == 2,
        )


class IntraEncoder:
    """Encodes every picture independently with VP8, like the thesis's JPEGs (3.5, 4.2).

    All have about the same size, given by the rendition's bit rate. Not thread-safe.
    """

    def __init__(self, rendition: RenditionSettings) -> None:
        self._rendition = rendition
        self._context = context_for("libvpx", rendition)
        self._context.gop_size = 0
        # In percent of the mean size: without it rate control exceeds the rate by a third.
        self._context.options = _steady(rendition) | _VP8_REALTIME | {"max-intra-rate": "100"}
        self._newest_pts = -1
        self._even_pts = 0

    def encode(
        self,
        picture: Picture,
        *,
        keyframe: bool,  # noqa: ARG002  # every picture is one
    ) -> EncodedPicture | None:
        """Encode one picture; None if its capture time is not newer than the previous one's."""
        pts = round(picture.captured_s * VIDEO_RATE_HZ)
        if pts <= self._newest_pts:
            return None
        self._newest_pts = pts
        # Evenly spaced for the rate control, so that a late picture does not become larger.
        self._even_pts += round(VIDEO_RATE_HZ / self._rendition.fps)
        data = _encode(self._context, self._rendition, picture, self._even_pts, PictureType.I)
        if not data:
            return None
        return EncodedPicture(
            data=data,
            pts=pts,
            rendition=self._rendition.name,
            keyframe=True,
            layer=0,
            captured_s=picture.captured_s,
        )


def _encode(
    context: av.VideoCodecContext,
    rendition: RenditionSettings,
    picture: Picture,
    pts: int,
    kind: PictureType,
) -> bytes:
    """Return the encoded picture, empty if the encoder dropped it."""
    frame = frame_of(picture, rendition)
    frame.pts = pts
    frame.time_base = VIDEO_TIME_BASE
    frame.pict_type = kind
    return b"".join(bytes(packet) for packet in context.encode(frame))


def frame_of(picture: Picture, rendition: RenditionSettings) -> VideoFrame:
    """Return the picture in the rendition's size; do not change its array while this is in use."""
    i420 = np.ascontiguousarray(resize_i420(picture.i420, rendition.width, rendition.height))
    # Without a copy PyAV takes only whole fours of rows, and would cut off the others.
    if rendition.height % 4:
        return VideoFrame.from_ndarray(i420, format="yuv420p")
    return VideoFrame.from_numpy_buffer(i420, format="yuv420p")


def resize_i420(i420: NDArray[np.uint8], width: int, height: int) -> NDArray[np.uint8]:
    """Scale a planar picture, shape ``(h * 3 // 2, w)``, plane by plane to an even size.

    A chroma plane may have an odd number of rows, so that the next one begins within a row.
    """
    old_width = i420.shape[1]
    old_height = i420.shape[0] * 2 // 3
    if (old_width, old_height) == (width, height):
        return i420
    resized = np.empty((height * 3 // 2, width), np.uint8)
    for plane, target in zip(planes(np.ascontiguousarray(i420)), planes(resized), strict=True):
        _scale(plane, target)
    return resized


def _scale(plane: NDArray[np.uint8], target: NDArray[np.uint8]) -> None:
    (height, width), (new_height, new_width) = plane.shape, target.shape
    if height >= 4 * new_height and width >= 4 * new_width:
        # OpenCV halves a picture in a tenth of the time in which it quarters one.
        half = np.empty((height // 2, width // 2), np.uint8)
        cv2.resize(plane, half.shape[::-1], dst=half, interpolation=cv2.INTER_AREA)
        _scale(half, target)
    else:
        way = cv2.INTER_AREA if new_width < width else cv2.INTER_LINEAR
        cv2.resize(plane, (new_width, new_height), dst=target, interpolation=way)


def _vp8(rendition: RenditionSettings, *, is_hurried: bool) -> av.VideoCodecContext:
    context = context_for("libvpx", rendition)
    kbps = rendition.bitrate_bps // 1000
    is_small = rendition.width * rendition.height * rendition.fps <= _SMALL_PIXELS_PER_S
    context.options = (
        _steady(rendition)
        | _VP8_REALTIME
        | (_VP8_SMALL if is_small else _VP8_HURRIED if is_hurried else {})
        | {
            "max-intra-rate": "300",
            "ts-parameters": (
                f"ts_number_layers=3:ts_target_bitrate={kbps * 4 // 10},{kbps * 6 // 10},{kbps}"
                ":ts_rate_decimator=4,2,1:ts_periodicity=4:ts_layer_id=0,2,1,2:ts_layering_mode=3"
            ),
        }
    )
    return context


def _h264(rendition: RenditionSettings, *, is_hurried: bool) -> av.VideoCodecContext:
    context = context_for("libx264", rendition)
    context.profile = "Baseline"
    context.options = _steady(rendition) | {
        # As sharp as "veryfast" but for 0.003 of SSIM, in 2/3 of its time; "ultrafast" loses 0.015.
        "preset": "ultrafast" if is_hurried else "superfast",
        "tune": "zerolatency",
        # Threads within one small picture cost more than they gain.
        "x264-params": "scenecut=0:sliced-threads=0:threads=1",
    }
    if _fits_level_31(rendition):
        context.options |= {"level": "31"}
    return context


def _fits_level_31(rendition: RenditionSettings) -> bool:
    """Return whether level 3.1 suffices; above it x264 chooses the level."""
    columns, rows = (rendition.width + 15) // 16, (rendition.height + 15) // 16
    return (
        columns * rows <= _LEVEL_31_MACROBLOCKS
        and max(columns, rows) ** 2 <= 8 * _LEVEL_31_MACROBLOCKS
        and columns * rows * rendition.fps <= _LEVEL_31_MACROBLOCKS_PER_S
        and rendition.bitrate_bps <= _LEVEL_31_BITRATE_BPS
    )


def _steady(rendition: RenditionSettings) -> dict[str, str]:
    """Constant bit rate with a buffer of half a second: bursts are delay on a slow link."""
    rate = str(rendition.bitrate_bps)
    return {"maxrate": rate, "minrate": rate, "bufsize": str(rendition.bitrate_bps // 2)}


def context_for(
    name: str, rendition: RenditionSettings, pixels: str = "yuv420p"
) -> av.VideoCodecContext:
    """Return FFmpeg's encoder of this name for the rendition, not yet opened."""
    context = av.CodecContext.create(name, "w")
    assert isinstance(context, av.VideoCodecContext)
    context.width = rendition.width
    context.height = rendition.height
    context.pix_fmt = pixels
    # A `Picture`'s colour space. VP8 has no other (RFC 6386, 9.2), and browsers show H.264 that
    # declares none as BT.709.
    context.color_range, context.colorspace = ColorRange.MPEG, Colorspace.ITU601
    context.time_base = VIDEO_TIME_BASE
    context.framerate = Fraction(rendition.fps).limit_denominator(1001)
    context.bit_rate = rendition.bitrate_bps
    context.gop_size = _NEVER
    context.thread_count = 1
    return context
