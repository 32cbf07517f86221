"""The size that a source has of its own."""

from __future__ import annotations

from itertools import repeat
from typing import TYPE_CHECKING, Any

import av
import cv2
import numpy as np
import pytest
from av.video.frame import VideoFrame
from tests.capture.file.http_camera import multipart, serving
from tests.idle_robot import IdleRobot

from wax.capture import own_size as module
from wax.capture.letterbox import black
from wax.capture.own_size import HD, VGA, Size, own_size
from wax.capture.source import Picture
from wax.capture.v4l2_modes import Mode
from wax.config.video import DrivingViewSettings
from wax.errors import SourceError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from wax.capture.source import VideoSource
    from wax.clock import Clock
    from wax.config.video import VideoSettings

WEBCAM = [Mode(640, 480, 30), Mode(800, 600, 30), Mode(1280, 720, 30), Mode(1920, 1080, 30)]


def found(source: str, modes: list[Mode] | None = None, **keys: Any) -> Size:
    video = DrivingViewSettings(source=source, **keys)
    return own_size(video, None, keys.get("most", HD), list_modes=lambda _: modes or []).size


@pytest.mark.parametrize(
    ("modes", "size"),
    [
        (WEBCAM, (1280, 720)),
        ([Mode(640, 480, 30), Mode(1280, 720, 10)], (640, 480)),
        ([Mode(640, 480, 15), Mode(1280, 720, 5)], (640, 480)),
        ([Mode(1920, 1080, 30)], (1280, 720)),
        ([Mode(1600, 1200, 30)], (960, 720)),
        ([Mode(320, 240, 30)], (320, 240)),
        ([], (1280, 720)),
    ],
)
def test_a_camera_has_its_largest_mode_that_is_fluent(
    modes: list[Mode], size: tuple[int, int]
) -> None:
    """It is at most 720p, and smaller rather than slower than 25 pictures a second."""
    assert found("camera:0", modes) == size


def test_a_slow_rate_is_enough_where_it_is_configured() -> None:
    """With fps = 10 a mode with ten pictures a second is fluent."""
    modes = [Mode(640, 480, 30), Mode(1280, 720, 10)]
    assert found("camera:0", modes, fps=10.0) == (1280, 720)


@pytest.mark.parametrize(
    ("source", "size"),
    [
        ("testcard", HD),
        ("picamera", HD),
        ("package.module:Class", HD),
        ("rtsp://127.0.0.1:9/", HD),
        ("http://127.0.0.1:9/stream.mjpg", VGA),
        ("none", HD),
    ],
)
def test_what_is_not_known_before_it_is_opened_has_a_usual_size(source: str, size: Size) -> None:
    """No camera is opened to learn a size, and who does not answer has a likely one."""
    assert found(source) == size


@pytest.mark.parametrize(
    ("film", "size"),
    [
        ((640, 360), (640, 360)),
        ((400, 300), (400, 300)),
        ((1080, 1920), (720, 1280)),
        ((1440, 1080), (960, 720)),
        ((1000, 420), (1000, 420)),
    ],
)
def test_a_film_keeps_its_shape(
    tmp_path: Path, film: tuple[int, int], size: tuple[int, int]
) -> None:
    """A film is scaled down to fit, lying or standing, and never enlarged."""
    path = tmp_path / "film.mp4"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mpeg4", rate=25)
        stream.width, stream.height, stream.pix_fmt = *film, "yuv420p"
        picture = np.zeros((film[1] * 3 // 2, film[0]), np.uint8)
        container.mux(stream.encode(VideoFrame.from_ndarray(picture, format="yuv420p")))
        container.mux(stream.encode(None))
    assert found(str(path)) == size


@pytest.mark.parametrize(
    ("given", "size"),
    [
        ((320, 180), (320, 180)),
        ((1920, 1080), (1280, 720)),
        ((960, 720), (960, 720)),
        ((102, 178), (102, 178)),
    ],
)
def test_a_stream_has_the_size_of_its_own(given: tuple[int, int], size: tuple[int, int]) -> None:
    """A network camera is asked at the start, once, and its pictures are never enlarged."""
    content = cv2.imencode(".jpg", np.full((given[1], given[0], 3), 90, np.uint8))[1].tobytes()
    asked: list[float] = []
    with serving(multipart(repeat(content, 60), 60.0, asked)) as address:
        assert found(address) == size


class RosRobot(IdleRobot):
    """Its camera fails `failures` times, and then gives pictures of this size."""

    kind = "ros2"

    def __init__(self, size: tuple[int, int], failures: int) -> None:
        self._size = size
        self._reads: Iterator[bool] = iter([False] * failures + [True])
        self.is_closed = False

    def camera(self, _settings: VideoSettings, _clock: Clock) -> VideoSource:
        return self

    def read(self) -> Picture:
        if next(self._reads):
            return Picture(black(*self._size), 1.0)
        raise SourceError("no picture yet")

    def close(self) -> None:
        self.is_closed = True


@pytest.mark.parametrize(
    ("given", "size"),
    [((480, 270), (480, 270)), ((1920, 1200), (1152, 720)), ((240, 320), (240, 320))],
)
def test_a_topic_has_the_size_of_its_pictures(
    monkeypatch: pytest.MonkeyPatch, given: tuple[int, int], size: tuple[int, int]
) -> None:
    """A ROS 2 robot is asked for one picture, which may take a while to come."""
    monkeypatch.setattr(module, "_AGAIN_S", 0.0)
    robot = RosRobot(given, failures=3)
    assert own_size(DrivingViewSettings(), robot, HD).size == size
    assert robot.is_closed


def test_a_topic_without_pictures_has_a_usual_size(monkeypatch: pytest.MonkeyPatch) -> None:
    """The server starts without waiting for a robot that is switched off."""
    monkeypatch.setattr(module, "_TOPIC_S", 0.0)
    robot = RosRobot((480, 270), failures=1)
    told = own_size(DrivingViewSettings(), robot, HD)
    assert told.size == VGA
    assert "guess" in told.why
    assert robot.is_closed
