"""A camera module through picamera2, with a stand-in for its documented interface."""

from __future__ import annotations

import sys
from types import ModuleType, SimpleNamespace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import pytest
from tests.turned_clock import TurnedClock

from wax.capture.find_sources import _Files, _find_video
from wax.capture.list_devices import _can_capture, list_modules
from wax.capture.picamera import PiCamera, load_picamera2, planar
from wax.clock import SystemClock
from wax.config.video import VideoSettings
from wax.errors import SourceError

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

SIZE = VideoSettings(source="picamera", width=160, height=120, fps=25)
PADDED = 192
"""libcamera pads rows to what the hardware likes."""


class Request:
    """One picture: `config`, `make_array`, `get_metadata` and `release`, as documented."""

    def __init__(self, camera: Picamera2) -> None:
        self._camera = camera
        self.config = {"main": camera.configuration["main"]}
        camera.held += 1

    def make_array(self, name: str) -> NDArray[np.uint8]:
        assert name == "main"
        width, height = self.config["main"]["size"]
        array = np.full((height * 3 // 2, PADDED), 7, np.uint8)
        array[:height, :width] = 100
        chroma = array[height:].reshape(height, PADDED // 2)
        chroma[: height // 2, : width // 2] = 110
        chroma[height // 2 :, : width // 2] = 120
        return array

    def get_metadata(self) -> dict[str, int]:
        return self._camera.metadata

    def release(self) -> None:
        self._camera.held -= 1


class Picamera2:
    """A stand-in for the class; a test sets what it reports."""

    there: ClassVar[list[dict[str, Any]]] = []
    made: ClassVar[list[Picamera2]] = []
    fault: ClassVar[dict[str, Exception]] = {}

    @staticmethod
    def global_camera_info() -> list[dict[str, Any]]:
        return Picamera2.there

    def __init__(self, camera_num: int = 0) -> None:
        self.number = camera_num
        self.configuration: dict[str, Any] = {}
        self.camera_controls = {
            "ExposureTime": (13, 112_015, None),
            "AeEnable": (False, True, True),
        }
        self.metadata: dict[str, int] = {"SensorTimestamp": 999_950_000_000}
        self.held = 0
        self.running = False
        self.closed = False
        self._raise("open")
        Picamera2.made.append(self)

    def create_video_configuration(self, **keys: Any) -> dict[str, Any]:
        return keys

    def configure(self, configuration: dict[str, Any]) -> None:
        self.configuration = configuration

    def start(self) -> None:
        self._raise("start")
        self.running = True

    def capture_request(self, *, wait: bool) -> str:
        assert not wait
        return "job"

    def wait(self, job: str, timeout: float) -> Request:
        assert (job, timeout < 2) == ("job", True)
        self._raise("wait")
        return Request(self)

    def stop(self) -> None:
        self._raise("stop")
        self.running = False

    def close(self) -> None:
        self.closed = True

    def _raise(self, act: str) -> None:
        if act in Picamera2.fault:
            raise Picamera2.fault[act]


@pytest.fixture(autouse=True)
def _module(monkeypatch: pytest.MonkeyPatch) -> None:
    module = ModuleType("picamera2")
    module.Picamera2 = Picamera2  # type: ignore[attr-defined]  # made here
    monkeypatch.setitem(sys.modules, "picamera2", module)
    libcamera = ModuleType("libcamera")
    libcamera.ColorSpace = SimpleNamespace(Smpte170m=lambda: "SMPTE170M")  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "libcamera", libcamera)
    monkeypatch.setattr(
        Picamera2,
        "there",
        [
            {"Model": "imx708", "Id": "/base/soc/i2c0mux/i2c@1/imx708@1a", "Num": 0},
            {"Model": "imx219", "Id": "/base/soc/i2c0mux/i2c@0/imx219@10", "Num": 1},
            {"Model": "HD Webcam", "Id": "/base/scb/pcie@7d500000/usb@0,0-1.3:1.0", "Num": 2},
        ],
    )
    monkeypatch.setattr(Picamera2, "made", [])
    monkeypatch.setattr(Picamera2, "fault", {})


def camera(settings: VideoSettings = SIZE) -> PiCamera:
    return PiCamera(settings, TurnedClock(50.0), boot_s=lambda: 1000.0)


def test_a_picture_has_its_planes_and_the_moment_of_exposure() -> None:
    """Rows lose their padding, and the sensor's time, here 50 ms ago, becomes the server's."""
    source = camera()
    source.open()
    picture = source.read()
    assert (picture.width, picture.height) == (160, 120)
    assert (picture.i420[:120] == 100).all()
    assert (picture.i420[120:150] == 110).all()
    assert (picture.i420[150:] == 120).all()
    assert picture.captured_s == pytest.approx(49.95)
    (made,) = Picamera2.made
    assert made.held == 0
    assert made.configuration["main"] == {"size": (160, 120), "format": "YUV420"}
    assert made.configuration["controls"] == {"FrameRate": 25}
    assert made.configuration["colour_space"] == "SMPTE170M"
    source.close()
    assert (made.running, made.closed) == (False, True)
    source.close()


def test_controls_are_libcameras_own() -> None:
    """The configured controls are set; an unknown name is a sentence that lists the known ones."""
    source = camera(SIZE.model_copy(update={"controls": {"ExposureTime": 8000}}))
    source.open()
    assert Picamera2.made[0].configuration["controls"]["ExposureTime"] == 8000
    source.close()
    source = camera(SIZE.model_copy(update={"controls": {"exposure": 8000}}))
    with pytest.raises(SourceError, match=r"has no control exposure; it has: AeEnable, Exposure"):
        source.open()
    assert Picamera2.made[1].closed


@pytest.mark.parametrize("metadata", [{}, {"SensorTimestamp": 0}, {"SensorTimestamp": 2 * 10**12}])
def test_a_time_that_cannot_be_is_not_believed(metadata: dict[str, int]) -> None:
    """A picture without a credible time is dated by its arrival."""
    source = camera()
    source.open()
    Picamera2.made[0].metadata = metadata
    assert source.read().captured_s == 50.0
    source.close()


def test_rows_without_padding_are_taken_as_they_are() -> None:
    """Rows without padding are not copied."""
    array = np.arange(180 * 160, dtype=np.uint32).astype(np.uint8).reshape(180, 160)
    assert planar(array, 160, 120) is not None
    assert np.shares_memory(planar(array, 160, 120), array)


@pytest.mark.parametrize(
    ("act", "error", "says"),
    [
        ("open", RuntimeError("Device or resource busy"), "cannot be opened (Device or resource"),
        ("start", RuntimeError("Camera in wrong state"), "cannot be opened (Camera in wrong"),
        ("wait", TimeoutError(), "delivers no picture; check its ribbon cable"),
        ("wait", RuntimeError("Camera frontend has timed out"), "has stopped: Camera frontend"),
    ],
)
def test_each_fault_is_a_sentence(act: str, error: Exception, says: str) -> None:
    """Whatever libcamera raises, the page says what to do, and the camera is closed."""
    Picamera2.fault[act] = error
    source = camera()

    def look() -> None:
        source.open()
        source.read()

    with pytest.raises(SourceError) as caught:
        look()
    assert says in str(caught.value)
    source.close()
    assert all(one.closed for one in Picamera2.made)


def test_one_that_does_not_stop_is_closed_all_the_same() -> None:
    """A camera that raises when it is stopped is closed anyway."""
    source = camera()
    source.open()
    Picamera2.fault["stop"] = RuntimeError("no")
    source.close()
    assert Picamera2.made[0].closed


def test_a_picture_that_breaks_is_given_back(monkeypatch: pytest.MonkeyPatch) -> None:
    """A picture whose reading fails still returns its buffer to the camera."""
    source = camera()
    source.open()

    def broken(self: Request, name: str) -> None:
        raise ValueError("no memory")

    monkeypatch.setattr(Request, "make_array", broken)
    with pytest.raises(ValueError, match="no memory"):
        source.read()
    assert Picamera2.made[0].held == 0
    source.close()


@pytest.mark.parametrize(("name", "number"), [("picamera", 0), ("picamera:1", 1)])
def test_it_is_found_by_its_name(name: str, number: int) -> None:
    """The names in the manual select the camera by libcamera's number."""
    settings = SIZE.model_copy(update={"source": name})
    source = _find_video(settings, "[video] source", SystemClock(), _Files(SystemClock()))
    assert isinstance(source, PiCamera)
    source.open()
    assert Picamera2.made[0].number == number
    source.close()


def test_what_is_not_there_is_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    """No camera, too high a number, and a missing or broken picamera2 are sentences."""
    far = camera(SIZE.model_copy(update={"source": "picamera:7"}))
    with pytest.raises(SourceError, match="Libcamera finds no camera 7"):
        far.open()
    Picamera2.there.clear()
    with pytest.raises(SourceError, match="Libcamera finds no camera; check"):
        camera().open()
    monkeypatch.setitem(sys.modules, "picamera2", None)
    with pytest.raises(SourceError, match="sudo apt install python3-picamera2"):
        load_picamera2()
    assert list_modules() == []

    def of_another_version(name: str) -> None:
        raise AttributeError("libcamera has no controls")

    monkeypatch.setattr("importlib.import_module", of_another_version)
    with pytest.raises(SourceError, match="picamera2 cannot be used: libcamera has no controls"):
        load_picamera2()


def test_modules_are_listed_without_usb_cameras() -> None:
    """`wax devices` lists each camera once: V4L2 has those on USB."""
    assert [(one.source, one.name) for one in list_modules()] == [
        ("picamera:0", "imx708"),
        ("picamera:1", "imx219"),
    ]


@pytest.mark.parametrize(("driver", "listed"), [(b"uvcvideo", True), (b"unicam", False)])
def test_what_a_module_is_made_of_is_no_camera(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, driver: bytes, listed: bool
) -> None:
    """A node that only libcamera can use is not listed as a camera."""
    (tmp_path / "video0").write_bytes(b"")

    def ioctl(node: object, request: int, answer: bytearray) -> int:
        answer[: len(driver)] = driver
        answer[88:92] = (0x04200001).to_bytes(4, "little")
        return 0

    monkeypatch.setattr("fcntl.ioctl", ioctl)
    assert _can_capture(tmp_path / "video0") is listed
