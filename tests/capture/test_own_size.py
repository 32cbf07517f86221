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

from wax.capture.own_size import HD, VGA, Size, own_size
from wax.capture.v4l2_modes import Mode
from wax.config.video import DrivingViewSettings

if TYPE_CHECKING:
    from pathlib import Path

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
