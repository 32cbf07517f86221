"""Sources by name: each name in the manual finds its source, each mistake is a sentence."""

from __future__ import annotations

import sys
import wave
from types import ModuleType
from typing import TYPE_CHECKING

import pytest
from structlog.testing import capture_logs
from tests.capture.seeing_robot import SeeingRobot
from tests.idle_robot import IdleRobot

from wax.capture.camera import OpenCvCamera
from wax.capture.file.media_file import FileAudio, FileVideo
from wax.capture.find_sources import Sources, make_camera, make_sources, warn_of_shared_addresses
from wax.capture.microphone import PortAudioMicrophone
from wax.capture.testcard import TestCardAudio, TestCardVideo
from wax.clock import Clock, SystemClock
from wax.config.audio import AudioSettings
from wax.config.camera import CameraSettings
from wax.config.video import VideoSettings
from wax.driver.interface import Limits
from wax.errors import ConfigError

if TYPE_CHECKING:
    from pathlib import Path

    from wax.capture.source import Picture, VideoSource


def find(video: str = "none", audio: str = "none", robot: IdleRobot | None = None) -> Sources:
    return make_sources(
        VideoSettings(source=video),
        AudioSettings(source=audio),
        SystemClock(),
        robot or IdleRobot(),
    )


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("testcard", TestCardVideo),
        ("0", OpenCvCamera),
        ("camera:2", OpenCvCamera),
        ("/dev/video4", OpenCvCamera),
        ("/dev/v4l/by-id/usb-Acme_Cam-video-index0", OpenCvCamera),
        ("camera:/dev/v4l/by-path/pci-0000:00:14.0-usb-0:1:1.0-video-index0", OpenCvCamera),
        ("camera:/run/robot/eye", OpenCvCamera),
        ("rtsp://10.0.0.1/stream", FileVideo),
        ("http://user:word@robot:81/a.mjpg", FileVideo),
    ],
)
def test_each_name_of_a_picture(name: str, kind: type) -> None:
    """Each name in the manual builds its video source without opening it."""
    assert type(find(video=name).video) is kind


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("testcard", TestCardAudio),
        ("microphone", PortAudioMicrophone),
        ("microphone:3", PortAudioMicrophone),
        ("microphone:USB Webcam", PortAudioMicrophone),
        ("microphone:pulse", PortAudioMicrophone),
        ("microphone:hw:1,0", PortAudioMicrophone),
        ("rtsp://10.0.0.1/stream", FileAudio),
    ],
)
def test_each_name_of_a_sound(name: str, kind: type) -> None:
    """Each name in the manual builds its audio source without opening it."""
    assert type(find(audio=name).audio) is kind


@pytest.mark.parametrize(
    ("before", "now"),
    [
        ("alsa:hw:1", '"microphone:hw:1,0"'),
        ("alsa:plughw:2,1", '"microphone:hw:2,1"'),
        ("alsa:plughw:CARD=Webcam,DEV=0", "microphone:… with a part of the device's name"),
    ],
)
def test_a_name_of_alsas_is_told_its_new_one(before: str, now: str) -> None:
    """An ALSA device name stops the start with the name to write instead."""
    with pytest.raises(ConfigError) as caught:
        find(audio=before)
    assert str(caught.value).startswith(f"[audio] source: {before} is now {now}")


def test_a_device_is_passed_on_as_it_is_written() -> None:
    """Numbers become numbers, names stay names, and an empty name is the default device."""
    names = [find(audio=name).audio for name in ("microphone", "microphone:3", "microphone:USB")]
    assert [str(getattr(m, "name", None)) for m in names] == [
        "The microphone",
        "Microphone 3",
        "Microphone USB",
    ]
    cameras = [find(video=name).video for name in ("camera:2", "camera:/dev/v4l/by-id/eye")]
    assert [getattr(camera, "name", None) for camera in cameras] == [
        "Camera 2",
        "Camera /dev/v4l/by-id/eye",
    ]


def test_none_is_none() -> None:
    """The value "none" configures no source."""
    assert find() == Sources(None, None)


def test_the_robots_own_senses() -> None:
    """The value "robot" takes the driver's device, or fails with a sentence if it has none."""
    sources = find("robot", "robot", SeeingRobot())
    assert isinstance(sources.video, TestCardVideo)
    assert isinstance(sources.audio, TestCardAudio)
    with pytest.raises(ConfigError, match=r"^\[video\] source: the idle robot has no camera"):
        find(video="robot")
    with pytest.raises(ConfigError, match=r"^\[audio\] source: the idle robot has no micro"):
        find(audio="robot")


def test_a_file_named_twice_is_one_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Picture and sound of one file, however its path is written, share a demuxer; two do not."""
    for name in ("a.mp4", "b.mp4"):
        with wave.open(str(tmp_path / name), "wb") as silence:
            silence.setparams((1, 2, 8000, 80, "NONE", ""))
            silence.writeframes(bytes(160))
    monkeypatch.chdir(tmp_path)
    same = find("a.mp4", str(tmp_path / "." / "a.mp4"))
    other = find("a.mp4", "b.mp4")
    for sources, shared in ((same, True), (other, False)):
        assert isinstance(sources.video, FileVideo)
        assert isinstance(sources.audio, FileAudio)
        assert (sources.video._file == sources.audio._file) is shared


def find_one(key: str, name: str) -> Sources:
    return find(video=name) if key == "video" else find(audio=name)


@pytest.mark.parametrize("key", ["video", "audio"])
def test_a_missing_file_names_key_and_path(tmp_path: Path, key: str) -> None:
    """A path that does not exist stops the start with key, path and the possible values."""
    path = str(tmp_path / "gone.mp4")
    with pytest.raises(ConfigError) as caught:
        find_one(key, path)
    sentence = str(caught.value)
    assert sentence.startswith(f"[{key}] source: {path} does not exist")
    assert "wax devices" in sentence
    with pytest.raises(ConfigError, match="not a file"):
        find_one(key, str(tmp_path))


@pytest.mark.parametrize("key", ["video", "audio"])
def test_a_file_that_is_no_film_stops_the_start(tmp_path: Path, key: str) -> None:
    """A text file under a film's name stops the start with key, file and what to do."""
    diary = tmp_path / "diary.mp4"
    diary.write_text("These are words.\n" * 40)
    with pytest.raises(
        ConfigError, match=rf"^\[{key}\] source: diary.mp4 is not a playable video or sound"
    ):
        find_one(key, str(diary))


class Glass:
    """A plug-in source."""

    def __init__(self, settings: VideoSettings, clock: Clock) -> None:
        if settings.width == 32:
            raise ValueError("too small")

    def open(self) -> None: ...

    def read(self) -> Picture: ...  # type: ignore[empty-body]  # never read here

    def close(self) -> None: ...


def test_somebody_elses_class(monkeypatch: pytest.MonkeyPatch) -> None:
    """`package.module:Class` is built with settings and clock, and refused if it is no source."""
    module = ModuleType("glass_eye")
    module.Glass = Glass  # type: ignore[attr-defined]  # made here
    module.Stone = dict  # type: ignore[attr-defined]  # made here
    monkeypatch.setitem(sys.modules, "glass_eye", module)
    assert isinstance(find(video="glass_eye:Glass").video, Glass)
    with pytest.raises(ConfigError, match="glass_eye:Stone has no method open"):
        find(audio="glass_eye:Stone")
    with pytest.raises(ConfigError, match="glass_eye has no class Water"):
        find(video="glass_eye:Water")
    with pytest.raises(ConfigError, match="too small"):
        make_sources(
            VideoSettings(source="glass_eye:Glass", width=32, height=32),
            AudioSettings(source="none"),
            SystemClock(),
            IdleRobot(),
        )


class WatchedRobot(IdleRobot):
    """A driver with a camera that films the robot, and an arm that turns it."""

    limits = Limits(1.0, 1.0, axes=("arm",))

    def external_view(self, settings: VideoSettings, clock: Clock) -> VideoSource:
        return TestCardVideo(settings, clock)


def test_a_camera_beside_the_driving_view_is_found() -> None:
    """`[[camera]]` takes the values that `[video]` takes; "robot" is its external view."""
    clock = SystemClock()
    card = CameraSettings(name="Door", source="testcard")
    assert isinstance(make_camera(card, clock, IdleRobot()), TestCardVideo)
    device = CameraSettings(name="Door", source="camera:7")
    assert isinstance(make_camera(device, clock, IdleRobot()), OpenCvCamera)
    own = CameraSettings(name="Above", source="robot", axes=["arm"])
    assert isinstance(make_camera(own, clock, WatchedRobot()), TestCardVideo)


def test_an_address_that_two_tables_open_is_told() -> None:
    """An address in two tables is warned of, but not in `[video]` and `[audio]`, which share it."""
    yard, door = (
        CameraSettings(name=name, source="http://me:secret@cam:81/stream")
        for name in ("Yard", "Door")
    )
    with capture_logs() as logs:
        warn_of_shared_addresses("rtsp://cam/1", "rtsp://cam/1", [yard])
        warn_of_shared_addresses(
            "testcard", "none", [CameraSettings(name="Card", source="testcard")]
        )
    assert not logs
    with capture_logs() as logs:
        warn_of_shared_addresses("rtsp://cam/1", "none", [yard, door])
    (told,) = logs
    assert told["address"] == "http://cam:81/stream"
    assert told["tables"] == ["[[camera]] Yard", "[[camera]] Door"]


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        ({"source": "robot"}, "camera Door: source: the idle robot has no view of itself"),
        ({"source": "nowhere.mp4"}, "camera Door: source: nowhere.mp4 does not exist"),
        ({"source": "no.such:Class"}, "camera Door: source: no.such:Class: cannot import"),
        (
            {"source": "testcard", "axes": ["pan"]},
            "camera Door: axes: the idle robot has no axis pan; its axes are: none",
        ),
    ],
)
def test_a_camera_that_cannot_be_is_named(keys: dict[str, object], says: str) -> None:
    """An error in one of several cameras names that camera."""
    settings = CameraSettings.model_validate({"name": "Door", **keys})
    with pytest.raises(ConfigError) as refused:
        make_camera(settings, SystemClock(), IdleRobot())
    assert str(refused.value).startswith(says)


def test_an_address_has_no_controls() -> None:
    """Controls of a network address are refused in a sentence without the password."""
    address = "rtsp://me:secret@10.0.0.9/live"
    settings = VideoSettings(source=address, controls={"auto_exposure": 1})
    with pytest.raises(ConfigError, match=r"^\[video\] controls: rtsp://10\.0\.0\.9/live has none"):
        make_sources(settings, AudioSettings(source="none"), SystemClock(), IdleRobot())
