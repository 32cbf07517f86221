"""The robot's pictures, from their topic to a `Picture`."""

from __future__ import annotations

import base64
import contextlib
import threading
import time
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
import pytest
from tests.examples import at_length
from tests.robot.ros2.base import Base, own_domain
from tests.robot.ros2.bridge import Bridge
from tests.robot.ros2.robots import ros2_settings
from tests.turned_clock import TurnedClock

from wax.capture.own_size import HD, own_size
from wax.capture.stream_dating import LIVE_WITHIN_S
from wax.clock import SystemClock
from wax.config.video import DrivingViewSettings, VideoSettings
from wax.driver.interface import HasCamera
from wax.errors import SourceError
from wax.robot.find_driver import make_driver, make_robot
from wax.robot.ros2.camera import Ros2Camera
from wax.robot.ros2.images import to_bgr
from wax.robot.ros2.settings import Ros2Settings

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from wax.capture.source import VideoSource

BGR = np.zeros((6, 8, 3), np.uint8)
BGR[:, :4] = (200, 30, 10)
BGR[:, 4:] = (20, 220, 60)


def raw(encoding: str, pixels: Any, *, pad: int = 0) -> SimpleNamespace:
    rows = np.asarray(pixels, np.uint8).reshape(6, -1)
    rows = np.pad(rows, ((0, 0), (0, pad)))
    return SimpleNamespace(
        height=6,
        width=8,
        encoding=encoding,
        is_bigendian=0,
        step=rows.shape[1],
        data=rows.tobytes(),
    )


@pytest.mark.parametrize("pad", [0, 5])
@pytest.mark.parametrize(
    ("encoding", "pixels"),
    [
        ("bgr8", BGR),
        ("rgb8", BGR[:, :, ::-1]),
        ("bgra8", cv2.cvtColor(BGR, cv2.COLOR_BGR2BGRA)),
        ("rgba8", cv2.cvtColor(BGR, cv2.COLOR_BGR2RGBA)),
    ],
)
def test_colours_are_in_their_order(encoding: str, pixels: Any, pad: int) -> None:
    """Each order of colours becomes OpenCV's, even with padded rows."""
    assert np.array_equal(to_bgr(raw(encoding, pixels, pad=pad)), BGR)


def test_grey_and_subsampled_colour_are_decoded() -> None:
    """One octet a pixel is grey; UYVY and YUYV differ in where they have the luma."""
    grey = np.full((6, 8), 77, np.uint8)
    assert to_bgr(raw("mono8", grey)).max() == 77
    uyvy = np.tile(np.array([128, 180], np.uint8), (6, 8))
    bright = to_bgr(raw("yuv422", uyvy))
    assert np.array_equal(bright, to_bgr(raw("yuv422_yuy2", uyvy[:, ::-1])))
    assert abs(int(bright[0, 0, 0]) - 191) < 3


@pytest.mark.parametrize("encoding", ["mono16", "16UC1"])
def test_16_bit_grey_is_decoded_in_both_byte_orders(encoding: str) -> None:
    """16 bits a pixel are full-range grey, whichever octet comes first."""
    for big, order in ((0, "<u2"), (1, ">u2")):
        deep = np.full((6, 8), 77 * 257, order)
        message = raw(encoding, deep.view(np.uint8))
        message.is_bigendian = big
        assert (to_bgr(message) == 77).all()


@pytest.mark.parametrize("first", ["rggb", "bggr", "gbrg", "grbg"])
def test_a_bayer_mosaic_gets_its_colours(first: str) -> None:
    """The encoding names the colours of the first four pixels, row by row."""
    values = {"r": 200, "g": 100, "b": 30}
    tile = np.array([values[one] for one in first]).reshape(2, 2)
    found = to_bgr(raw(f"bayer_{first}8", np.tile(tile, (3, 4))))
    assert (found[2, 4] == (30, 100, 200)).all()


def test_compressed_pictures_are_decoded() -> None:
    """Compressed pictures are decoded, even in base64, as in JSON."""
    done, png = cv2.imencode(".png", BGR)
    assert done
    message = SimpleNamespace(format="png", data=png.tobytes())
    assert np.array_equal(to_bgr(message), BGR)
    message = SimpleNamespace(format="png", data=base64.b64encode(png.tobytes()).decode())
    assert np.array_equal(to_bgr(message), BGR)


@pytest.mark.parametrize(
    ("message", "what"),
    [
        (raw("32FC1", BGR), "32FC1"),
        (SimpleNamespace(encoding="bgr8", height=6, width=8, step=24, data=b"short"), "5 octets"),
        (SimpleNamespace(encoding="bgr8", height=0, width=8, step=24, data=b""), "bgr8"),
        (SimpleNamespace(encoding="mono8", height=1, width=10**9, step=10**9, data=b""), "mono8"),
        (SimpleNamespace(encoding="bgr8", height="x", width=8, step=24, data=b""), "no picture"),
        (SimpleNamespace(format="jpeg", data=b"no jpeg"), "jpeg"),
        (SimpleNamespace(format="jpeg", data=b""), "jpeg"),
        (SimpleNamespace(format="jpeg", data=None), "no picture"),
        (SimpleNamespace(data=b""), "no picture"),
        (SimpleNamespace(format=["png"], data=b"no png"), "no picture"),
    ],
)
def test_an_invalid_picture_is_refused_with_its_encoding(message: Any, what: str) -> None:
    """The error says what the message is."""
    with pytest.raises(ValueError, match=what):
        to_bgr(message)


class Timed(TurnedClock):
    """A clock whose wall-clock time advances, too."""

    def wall_ms(self) -> int:
        return round(self.time_s * 1000)


class Replayed:
    """A link that delivers pictures with these stamps, one every 0.1 s."""

    def __init__(self, stamps_s: list[float], clock: TurnedClock) -> None:
        self._stamps_s = stamps_s
        self._clock = clock

    def take(self, timeout_s: float) -> list[tuple[str, Any]]:
        if not self._stamps_s:
            self._clock.time_s += timeout_s
            return []
        self._clock.time_s += 0.1
        stamp_s = self._stamps_s.pop(0)
        message = raw("bgr8", BGR)
        stamp = SimpleNamespace(sec=int(stamp_s), nanosec=round(stamp_s % 1 * 1e9))
        message.header = SimpleNamespace(stamp=stamp)
        return [("camera", message)]

    def close(self) -> None: ...


def replayed(
    monkeypatch: pytest.MonkeyPatch, stamps_s: list[float], *, stamped: bool
) -> list[tuple[float, float | None]]:
    """Return each picture's age in s, and its error bound."""
    clock = Timed()
    link = Replayed(list(stamps_s), clock)
    monkeypatch.setattr("wax.robot.ros2.camera.open_link", lambda *_, **__: link)
    ros2 = Ros2Settings.model_validate({"camera": "/image", "stamped": stamped})
    source = Ros2Camera(ros2, VideoSettings(width=64, height=48), clock)
    source.open()
    seen = []
    with contextlib.suppress(SourceError):
        while True:
            picture = source.read()
            seen.append((round(clock.now_s() - picture.captured_s, 3), picture.within_s))
    return seen


@pytest.mark.parametrize(
    ("off_s", "knows"), [(0.0, True), (-0.5, True), (0.5, False), (-9.3, False)]
)
def test_an_impossible_stamp_is_ignored(
    monkeypatch: pytest.MonkeyPatch, off_s: float, *, knows: bool
) -> None:
    """With a clock too far off, the picture is shown, but its age is unknown."""
    wall_s = Timed().wall_ms() / 1000
    stamps_s = [wall_s + off_s + 0.1 * number for number in range(1, 6)]
    seen = replayed(monkeypatch, stamps_s, stamped=True)
    assert [within_s is not None for _, within_s in seen] == [knows] * 5
    assert [age_s for age_s, _ in seen] == [-off_s if knows else 0.0] * 5


def test_without_a_common_clock_stamps_show_a_queue(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """By stamps of any clock, a picture that took longer than others is that much older."""
    jammed_s = [8.41, 8.42, 8.43, 8.53]
    stamps_s = [7.0 + 0.1 * number for number in range(15)] + jammed_s
    seen = replayed(monkeypatch, stamps_s, stamped=False)
    ages_s = [age_s for age_s, _ in seen[12:]]
    assert ages_s == pytest.approx([0, 0, 0, 0.09, 0.18, 0.27, 0.27], abs=0.01)
    assert [within_s for _, within_s in seen[12:]] == [LIVE_WITHIN_S] * 7


def test_a_picture_that_is_published_again_is_not_new(monkeypatch: pytest.MonkeyPatch) -> None:
    """With an unchanged stamp, as from a latched topic, it is left out, and soon of no age."""
    stamps_s = [7.0 + 0.1 * min(number, 12) for number in range(30)]
    seen = replayed(monkeypatch, stamps_s, stamped=False)
    assert [within_s is not None for _, within_s in seen[9:13]] == [False, True, True, True]
    assert all(within_s is None for _, within_s in seen[13:])
    assert 5 < len(seen[13:]) < 10


def test_what_came_during_a_rest_is_no_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody knows when it arrived; the next one is read, as fresh as any other."""
    clock = Timed()
    link = Replayed([7.0 + 0.1 * number for number in range(6)], clock)
    monkeypatch.setattr("wax.robot.ros2.camera.open_link", lambda *_, **__: link)
    ros2 = Ros2Settings.model_validate({"camera": "/image"})
    source = Ros2Camera(ros2, VideoSettings(width=64, height=48), clock)
    source.open()
    source.read()
    source.catch_up()
    source.read()
    assert len(link._stamps_s) == 3
    assert source.rest_s < 1.0


def camera(settings: Any) -> VideoSource:
    """Make a camera as the media process does, of a robot that is never opened."""
    robot = make_driver(settings, SystemClock())
    assert isinstance(robot, HasCamera)
    return robot.camera(VideoSettings(width=64, height=48), SystemClock())


@contextlib.contextmanager
def published(tell: Callable[[], None]) -> Iterator[None]:
    """Publish 20 pictures a second."""
    done = threading.Event()

    def publish() -> None:
        while not done.wait(0.05):
            tell()

    thread = threading.Thread(target=publish)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def assert_shows(source: VideoSource, tell: Callable[[], None]) -> None:
    """Read pictures for a while; check that the left half is blue, the right one green."""
    try:
        with published(tell):
            source.open()
            for _ in range(5):
                picture = source.read()
            now_s = SystemClock().now_s()
    finally:
        source.close()
    assert (picture.width, picture.height) == (64, 48)
    assert 0.0 <= now_s - picture.captured_s < 0.5
    bgr = cv2.cvtColor(picture.i420, cv2.COLOR_YUV2BGR_I420)
    assert bgr[24, 8].argmax() == 0
    assert bgr[24, 56].argmax() == 1


def big() -> Any:
    return cv2.resize(BGR, (640, 480), interpolation=cv2.INTER_NEAREST)


def jpeg() -> str:
    done, data = cv2.imencode(".jpg", big())
    assert done
    return base64.b64encode(data.tobytes()).decode()


@pytest.mark.system
@pytest.mark.parametrize("kind", ["Image", *at_length("CompressedImage")])
def test_pictures_come_by_dds(kind: str) -> None:
    """Pictures have the configured size, from a robot that is never opened."""
    pytest.importorskip("cyclonedds", reason='type: pip install "wax-teleop[ros2]"')
    domain, type_name = own_domain(), f"sensor_msgs/msg/{kind}"
    base = Base(domain).start()
    message: dict[str, Any] = {"format": "jpeg", "data": jpeg()}
    if kind == "Image":
        data = base64.b64encode(big().tobytes()).decode()
        message = {"width": 640, "height": 480, "step": 1920, "encoding": "bgr8", "data": data}
    try:
        settings = ros2_settings(domain, camera="/camera/image", camera_type=type_name)
        assert_shows(camera(settings), lambda: base.say(type_name, "/camera/image", message))
    finally:
        base.end()


@pytest.mark.system
def test_pictures_come_by_rosbridge() -> None:
    """By rosbridge, a compressed picture in base64 is shown."""
    bridge = Bridge().start()
    message = {"format": "jpeg", "data": jpeg(), "header": {"stamp": {"sec": 0, "nanosec": 0}}}
    try:
        settings = ros2_settings(
            0, transport="rosbridge", rosbridge_url=bridge.url, camera="/camera/image"
        )
        assert_shows(camera(settings), lambda: bridge.say("/camera/image", message))
    finally:
        bridge.end()


@pytest.mark.system
def test_a_topic_is_asked_for_its_size_before_the_server_starts() -> None:
    """A process of its own takes one picture in its own shape, and ends."""
    bridge = Bridge().start()
    wide = cv2.imencode(".jpg", cv2.resize(BGR, (480, 270)))[1]
    message = {"format": "jpeg", "data": base64.b64encode(wide.tobytes()).decode()}
    robot = make_robot(
        ros2_settings(0, transport="rosbridge", rosbridge_url=bridge.url, camera="/camera/image"),
        SystemClock(),
    )
    try:
        with published(lambda: bridge.say("/camera/image", message)):
            found = own_size(DrivingViewSettings(), robot, HD)
        assert found.size == (480, 270)
        assert "media_pid" not in robot.state().extra
    finally:
        bridge.end()
        robot.close()


@pytest.mark.system
def test_a_camera_without_pictures_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without pictures, or without a topic, opening fails instead of waiting for ever."""
    pytest.importorskip("cyclonedds", reason='type: pip install "wax-teleop[ros2]"')
    with pytest.raises(SourceError, match=r"robot\.ros2\.camera"):
        camera(ros2_settings(own_domain())).open()
    monkeypatch.setattr("wax.robot.ros2.camera.FIRST_S", 0.5)
    begun_s = time.monotonic()
    with pytest.raises(SourceError, match="No picture comes from /camera"):
        camera(ros2_settings(own_domain(), camera="/camera")).open()
    assert time.monotonic() - begun_s < 10.0
