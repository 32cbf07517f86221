"""The camera: requests what is configured, survives faulty devices, and never hangs its reader."""

from __future__ import annotations

import errno
import os
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
import pytest
from tests.turned_clock import TurnedClock
from tests.until import until

from wax.capture import camera as camera_module
from wax.capture.camera import OpenCvCamera, open_device
from wax.clock import SystemClock
from wax.config.video import VideoSettings
from wax.errors import SourceError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

VGA = VideoSettings(width=640, height=480)


class FakeDevice:
    """A camera whose every frame the test supplies."""

    def __init__(self, size: tuple[int, int] = (640, 480), *, opens: bool = True) -> None:
        self.opens = opens
        self.properties: dict[int, float] = {}
        self.frame = np.full((size[1], size[0], 3), 200, np.uint8)
        self.frames = threading.Semaphore(0)
        self.unplugged = False
        self.damaged = 0
        self.grabbed = self.decoded = 0
        self.released = threading.Event()

    def isOpened(self) -> bool:  # noqa: N802 - OpenCV's name
        return self.opens

    def set(self, propId: int, value: float, /) -> bool:  # noqa: N803 - OpenCV's name
        self.properties[propId] = value
        return True

    def grab(self) -> bool:
        self.frames.acquire(timeout=10)
        self.grabbed += 1
        return not self.unplugged

    def retrieve(self) -> tuple[bool, Any]:
        self.decoded += 1
        if self.damaged:
            self.damaged -= 1
            self.frames.release()
            return False, None
        return True, self.frame

    def release(self) -> None:
        self.released.set()


def camera(device: FakeDevice, settings: VideoSettings = VGA) -> OpenCvCamera:
    return OpenCvCamera(settings, TurnedClock(77.0), device=3, open_device=lambda _: device)


def kept_by(source: OpenCvCamera) -> Any:
    """Return the frame that the next read is to return at once."""
    kept = source._grabber and source._grabber._newest
    return kept and kept[0]


def test_a_picture_has_its_moment_and_size() -> None:
    """A frame becomes a picture of the configured size with the time of its arrival."""
    device = FakeDevice()
    source = camera(device)
    source.open()
    device.frames.release()
    picture = source.read()
    assert (picture.width, picture.height, picture.captured_s) == (640, 480, 77.0)
    device.frames.release()
    source.close()
    source.close()
    assert device.released.wait(5)


def test_the_device_is_asked_for_size_and_rate() -> None:
    """Size, rate and one buffer are requested; Motion JPEG only where raw is too much for USB."""
    small, large = FakeDevice(), FakeDevice()
    for device, settings in ((small, VGA), (large, VideoSettings(width=1280, height=720))):
        source = camera(device, settings)
        source.open()
        device.frames.release()
        source.close()
    assert small.properties == {
        cv2.CAP_PROP_FRAME_WIDTH: 640,
        cv2.CAP_PROP_FRAME_HEIGHT: 480,
        cv2.CAP_PROP_FPS: 30,
        cv2.CAP_PROP_BUFFERSIZE: 1,
    }
    assert next(iter(large.properties.items())) == (
        cv2.CAP_PROP_FOURCC,
        cv2.VideoWriter.fourcc(*"MJPG"),
    )


def test_controls_are_set_before_the_first_picture() -> None:
    """The camera's controls are set each time it opens; one that lacks them is released."""
    settings = VideoSettings(controls={"focus_absolute": 30})
    device = FakeDevice()
    told: list[tuple[int | str, Mapping[str, float]]] = []

    def refuse(camera: int | str, controls: Mapping[str, float]) -> None:
        told.append((camera, controls))
        raise SourceError("Camera 3 has no control focus_absolute.")

    source = OpenCvCamera(
        settings, TurnedClock(77.0), device=3, open_device=lambda _: device, set_controls=refuse
    )
    with pytest.raises(SourceError, match="no control focus_absolute"):
        source.open()
    source.close()
    assert told == [(3, {"focus_absolute": 30})]
    assert device.released.wait(5)


def test_another_shape_is_shown_in_proportion() -> None:
    """A camera that delivers 16:9 instead of the requested 4:3 is shown between black bars."""
    device = FakeDevice((1280, 720))
    source = camera(device)
    source.open()
    device.frames.release()
    luma = source.read().i420[:480]
    device.frames.release()
    source.close()
    assert luma.shape == (480, 640)
    assert luma[:59].max() < 20
    assert luma[62:418].min() > 150
    assert luma[-59:].max() < 20


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has a file for each camera")
@pytest.mark.parametrize(
    ("number", "says"),
    [
        (errno.ENOENT, "There is no camera 3: plug it in"),
        (errno.EACCES, "You may not open camera 3: .* usermod -aG video"),
        (errno.EBUSY, "Camera 3 is there but gives no pictures: end the other program"),
        (None, "Camera 3 is there but gives no pictures: end the other program"),
    ],
)
def test_a_camera_that_does_not_open_is_one_sentence(
    monkeypatch: pytest.MonkeyPatch, number: int | None, says: str
) -> None:
    """Missing, forbidden and busy cameras get sentences of their own; the device is released."""
    device = FakeDevice(opens=False)
    source = camera(device)
    asked: list[str] = []

    def open_file(path: str, _flags: int) -> int:
        asked.append(path)
        if number is not None:
            raise OSError(number, os.strerror(number))
        return os.dup(0)

    with monkeypatch.context() as patched:
        patched.setattr("wax.capture.camera.os.open", open_file)
        with pytest.raises(SourceError, match=says):
            source.open()
    assert asked == ["/dev/video3"]
    source.close()
    assert device.released.wait(5)


def test_unplugging_is_told_at_once() -> None:
    """A failed grab ends a reader's wait immediately."""
    device = FakeDevice()
    source = camera(device)
    source.open()
    device.unplugged = True
    device.frames.release()
    with pytest.raises(SourceError, match=r"^Camera 3 has stopped; check its cable"):
        source.read()
    source.close()
    assert device.released.wait(5)


def test_a_hanging_camera_is_told_within_two_seconds(monkeypatch: pytest.MonkeyPatch) -> None:
    """Though OpenCV blocks, read gives up and close returns; the device is released later."""
    assert camera_module._SILENT_S < 2.0
    monkeypatch.setattr(camera_module, "_SILENT_S", 0.05)
    device = FakeDevice()
    source = camera(device)
    source.open()
    with pytest.raises(SourceError, match=r"^Camera 3 delivers no picture"):
        source.read()
    source.close()
    assert not device.released.is_set()
    device.frames.release()
    assert device.released.wait(5)


def test_frames_are_decoded_while_the_last_one_is_used() -> None:
    """A reader that takes as long as two frames finds the newer one of them decoded."""
    device = FakeDevice()
    source = camera(device)
    source.open()
    device.frames.release()
    source.read()
    for grey in (0, 255, 0, 255):
        for shown in (100, grey):
            device.frame = np.full((480, 640, 3), shown, np.uint8)
            device.frames.release()
            until(lambda: kept_by(source) is device.frame)
        assert source.read().i420[:480].mean() == pytest.approx(16 + grey * 219 / 255, abs=1)
    device.frames.release()
    source.close()


def test_few_frames_are_decoded_that_nobody_reads() -> None:
    """The camera streams on while nobody reads, and the next read gets a new frame."""
    device = FakeDevice()
    source = camera(device)
    source.open()
    device.frames.release()
    source.read()
    device.frames.release(9)
    until(lambda: device.grabbed == 10)
    assert device.decoded <= 1 + 4
    device.frame = np.zeros((480, 640, 3), np.uint8)
    with ThreadPoolExecutor(1) as reader:
        picture = reader.submit(source.read)
        until(lambda: source._grabber is not None and source._grabber._to_decode)
        device.frames.release(9)
    assert picture.result().i420[:480].max() == 16
    until(lambda: device.grabbed == 19)
    device.frames.release()
    source.close()
    assert device.decoded <= 1 + 4 + 4


def test_a_damaged_frame_is_skipped() -> None:
    """A frame that cannot be decoded is skipped, and the next one is shown."""
    device = FakeDevice()
    device.damaged = 2
    source = camera(device)
    source.open()
    device.frames.release()
    assert source.read().width == 640
    device.frames.release()
    source.close()


def test_a_device_that_raises_is_one_sentence() -> None:
    """Any exception from OpenCV becomes a sentence."""
    device = FakeDevice()

    def explode() -> tuple[bool, Any]:
        raise cv2.error("boom")

    device.retrieve = explode  # type: ignore[method-assign]  # this device is broken
    source = camera(device)
    source.open()
    device.frames.release()
    with pytest.raises(SourceError, match=r"^Camera 3 failed: boom"):
        source.read()
    source.close()


def test_through_opencv_itself(tmp_path: Path) -> None:
    """OpenCV's own capture, here of a Motion JPEG file, works through the same code."""
    path = str(tmp_path / "a.avi")
    writer = cv2.VideoWriter(path, cv2.VideoWriter.fourcc(*"MJPG"), 30, (320, 240))
    for _ in range(300):
        writer.write(np.full((240, 320, 3), 180, np.uint8))
    writer.release()
    settings = VideoSettings(width=320, height=240)
    source = OpenCvCamera(
        settings, SystemClock(), open_device=lambda _: cv2.VideoCapture(path, cv2.CAP_ANY)
    )
    source.open()
    picture = source.read()
    assert picture.i420[:240].mean() == pytest.approx(16 + 180 * 219 / 255, abs=4)
    with pytest.raises(SourceError, match="has stopped"):
        list(iter(source.read, None))
    source.close()


def test_a_camera_that_is_not_there() -> None:
    """OpenCV reports a device that does not exist without an exception."""
    device = open_device("/dev/video-that-is-not-there")
    assert not device.isOpened()
    device.release()
