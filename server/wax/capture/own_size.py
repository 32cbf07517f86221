"""The size that a source has of its own, for a configuration that leaves it to the source."""

from __future__ import annotations

import time
from contextlib import suppress
from typing import TYPE_CHECKING, Final, NamedTuple

from av.error import FFmpegError

from wax.capture.file.address import is_network, is_rtsp, open_container
from wax.capture.find_sources import camera_device
from wax.capture.first_found import first_camera
from wax.capture.letterbox import inner_size
from wax.capture.v4l2_modes import Mode, list_modes
from wax.clock import SystemClock
from wax.driver.interface import HasCamera
from wax.errors import SourceError
from wax.folders import expanded
from wax.plugin import is_plugin_name

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from wax.capture.file.address import Transport
    from wax.capture.source import VideoSource
    from wax.config.video import VideoSettings
    from wax.driver.interface import Driver

ENOUGH_FPS: Final = 25.0
"""Fewer pictures a second are worse to drive by than smaller ones."""
_TOPIC_S: Final = 8.0
"""Until the first picture of a topic: its process starts, and robots find each other in seconds."""
_AGAIN_S: Final = 0.1


class Size(NamedTuple):
    """An even size in pixels."""

    width: int
    height: int

    def __str__(self) -> str:
        return f"{self.width}x{self.height}"


HD: Final = Size(1280, 720)
VGA: Final = Size(640, 480)


class OwnSize(NamedTuple):
    """A source's size, and why it is this one, for the log."""

    size: Size
    why: str


def own_size(
    video: VideoSettings,
    driver: Driver | None,
    most: Size,
    *,
    taken: Iterable[str] = (),
    list_modes: Callable[[int | str], list[Mode]] = list_modes,
) -> OwnSize:
    """Return the best size of this source that fits into `most`; `taken` is as in `make_sources`.

    A file, an address or a ROS 2 topic is opened for it, and no camera. What does not answer is
    given up after some seconds.
    """
    source = video.source
    if source in ("auto", "robot") and isinstance(driver, HasCamera):
        if not has_topic(video, driver):
            return OwnSize(most, "the robot's camera has any size")
        make_camera = getattr(driver, "lone_camera", driver.camera)
        return _of_topic(make_camera(video, SystemClock()), most)
    if source == "auto":
        source = first_camera(taken) or source
    device = camera_device(source)
    if device is not None:
        return _of_modes(list_modes(device), most, min(video.fps, ENOUGH_FPS))
    if is_network(source):
        return _of_stream(source, video.rtsp_transport, most)
    if source == "auto" or is_plugin_name(source) or not expanded(source).is_file():
        return OwnSize(most, "the source has any size")
    return _of_file(source, most)


def has_topic(video: VideoSettings, driver: Driver | None) -> bool:
    """Whether the pictures are those of a ROS 2 robot."""
    return video.source in ("auto", "robot") and driver is not None and driver.kind == "ros2"


def _of_modes(modes: Sequence[Mode], most: Size, least_fps: float) -> OwnSize:
    if not modes:
        return OwnSize(most, "the camera does not say what it has")
    fit = [one for one in modes if one.width <= most.width and one.height <= most.height]
    fluent = [one for one in fit if one.fps >= least_fps]
    if fluent:
        best = max(fluent, key=lambda one: (one.width * one.height, one.fps))
        return OwnSize(fitted(*best[:2], most), f"the camera has it at {best.fps:.3g} fps")
    best = max(fit or modes, key=lambda one: (one.fps, -one.width * one.height))
    return OwnSize(fitted(*best[:2], most), "the camera has none that is faster")


def _of_topic(source: VideoSource, most: Size) -> OwnSize:
    end_s = time.monotonic() + _TOPIC_S
    try:
        source.open()
        while True:
            try:
                picture = source.read()
            except SourceError:
                if time.monotonic() >= end_s:
                    raise
                time.sleep(_AGAIN_S)
            else:
                size = fitted(picture.width, picture.height, most)
                return OwnSize(size, "the topic's pictures have this shape")
    except SourceError:
        return OwnSize(VGA, "a guess, because no picture came from the topic at the start")
    finally:
        source.close()


def _of_stream(address: str, transport: Transport, most: Size) -> OwnSize:
    width, height = 0.0, 0.0
    failures = suppress(FFmpegError, OSError, SourceError, IndexError)
    with failures, open_container(address, transport) as container:
        stream = container.streams.video[0]
        if stream.codec_context is not None:
            width = stream.codec_context.width * float(stream.sample_aspect_ratio or 1)
            height = float(stream.codec_context.height)
    if width and height:
        return OwnSize(fitted(width, height, most), "the stream has this shape")
    # Most cameras with RTSP are wide, and the small ones with multipart JPEG are not.
    size = most if is_rtsp(address) else VGA
    return OwnSize(size, "a guess, because the stream did not answer at the start")


def _of_file(name: str, most: Size) -> OwnSize:
    try:
        with open_container(str(expanded(name))) as container:
            stream = container.streams.video[0]
            aspect = float(stream.sample_aspect_ratio or 1)
            frame = next(container.decode(stream))
    except (FFmpegError, OSError, SourceError, IndexError, StopIteration):
        return OwnSize(VGA, "the file does not say how large its pictures are")
    shape = frame.width * aspect, float(frame.height)
    size = fitted(*(shape[::-1] if round(frame.rotation / 90) % 2 else shape), most)
    return OwnSize(size, "the file has this shape")


def fitted(width: float, height: float, most: Size) -> Size:
    """Return the size in proportion that fits into `most`, lying or standing, never enlarged."""
    longer, shorter = most
    box = (longer, shorter) if width >= height else (shorter, longer)
    inner = inner_size(width, height, min(box[0], int(width)), min(box[1], int(height)))
    return Size(*(max(2 * (pixels // 2), 32) for pixels in inner))
