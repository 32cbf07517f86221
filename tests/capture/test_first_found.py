"""`source = "auto"`: the first camera and microphone found, and never another camera later."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest
from structlog.testing import capture_logs
from tests.capture.seeing_robot import SeeingRobot
from tests.idle_robot import IdleRobot

from wax.capture import find_sources
from wax.capture.file.media_file import FileVideo
from wax.capture.find_sources import make_sources
from wax.capture.first_found import FirstCamera, first_microphone
from wax.capture.list_devices import ListedDevice
from wax.capture.microphone import PortAudioMicrophone
from wax.capture.testcard import TestCardAudio, TestCardVideo
from wax.clock import SystemClock
from wax.config import settings as config
from wax.config.audio import AudioSettings
from wax.config.video import DrivingViewSettings, VideoSettings
from wax.errors import ConfigError, SourceError

if TYPE_CHECKING:
    from wax.capture.source import VideoSource

CARD = VideoSettings(source="testcard", width=160, height=120)


def device(source: str, name: str) -> ListedDevice:
    return ListedDevice("[video] source", source, name)


class Rig:
    """Cameras to plug in and unplug, and a record of the sources built."""

    def __init__(self, *plugged: ListedDevice, taken: tuple[str, ...] = ()) -> None:
        self.plugged = list(plugged)
        self.made: list[str] = []
        self.broken = False
        self.camera = FirstCamera(self._make, taken=taken, list_cameras=lambda: self.plugged)

    def _make(self, name: str) -> VideoSource:
        if self.broken:
            raise SourceError("It is broken.")
        self.made.append(name)
        return TestCardVideo(CARD, SystemClock())


def test_the_first_camera_is_taken_and_named() -> None:
    """Of two cameras the first is opened, and the log says how to configure it."""
    rig = Rig(device("/dev/video0", "Front"), device("/dev/video2", "Rear"))
    with capture_logs() as logs:
        rig.camera.open()
    assert rig.camera.read().width == 160
    rig.camera.close()
    assert rig.made == ["/dev/video0"]
    assert [(one["camera"], one["write"]) for one in logs] == [
        ("Front", '[video] source = "/dev/video0"')
    ]


def test_without_a_camera_it_keeps_looking() -> None:
    """Without a camera a sentence says what to do, and one that is plugged in later is opened."""
    rig = Rig()
    with pytest.raises(SourceError, match="No camera was found: plug one in"):
        rig.camera.open()
    rig.plugged = [device("/dev/video0", "Front")]
    rig.camera.open()
    assert rig.made == ["/dev/video0"]


def test_nobody_suddenly_drives_by_another_camera() -> None:
    """An unplugged camera is waited for, even under another number; others are not opened."""
    front, rear = device("/dev/video0", "Front"), device("/dev/video2", "Rear")
    rig = Rig(front, rear)
    rig.camera.open()
    rig.plugged = [rear]
    with pytest.raises(SourceError, match="The camera Front has gone"):
        rig.camera.open()
    rig.plugged = [rear, device("/dev/video4", "Front")]
    rig.camera.open()
    assert rig.made == ["/dev/video0", "/dev/video4"]


def test_of_two_alike_the_same_one_is_opened_again() -> None:
    """Two cameras of one model are told apart by number while both are present."""
    rig = Rig(device("/dev/video0", "Acme"), device("/dev/video2", "Acme"))
    rig.camera.open()
    rig.plugged.reverse()
    rig.camera.open()
    assert rig.made == ["/dev/video0", "/dev/video0"]


def test_its_twin_is_not_taken_for_it() -> None:
    """When the chosen one of two identical cameras is gone, the other is not opened."""
    front, rear = device("/dev/video0", "Acme"), device("/dev/video2", "Acme")
    rig = Rig(front, rear)
    rig.camera.open()
    rig.plugged = [rear]
    with pytest.raises(SourceError, match="The camera Acme has gone"):
        rig.camera.open()
    rig.plugged = [rear, front]
    rig.camera.open()
    assert rig.made == ["/dev/video0", "/dev/video0"]


def test_one_that_never_opened_binds_to_nothing() -> None:
    """A camera that never opened does not exclude others once it is gone."""
    rig = Rig(device("/dev/video0", "Broken"))
    rig.broken = True
    with pytest.raises(SourceError, match="broken"):
        rig.camera.open()
    rig.broken = False
    rig.plugged = [device("/dev/video2", "Good")]
    rig.camera.open()
    assert rig.made == ["/dev/video2"]


@pytest.mark.parametrize("name", ["/dev/video0", "camera:/dev/video0", "camera:0", "0"])
def test_a_further_cameras_device_is_left_alone(name: str) -> None:
    """A device of `[[camera]]` is not chosen, however it is written there."""
    rig = Rig(device("/dev/video0", "Rear"), device("/dev/video2", "Front"), taken=(name,))
    rig.camera.open()
    assert rig.made == ["/dev/video2"]


class Sounds:
    """PortAudio with these inputs, one of which may be the default."""

    def __init__(self, *names: str, default: str | None = None) -> None:
        self._names, self._default = names, default

    def query_devices(self, name: str | None = None, kind: str | None = None) -> Any:
        if (name, kind) == (None, None):
            return [{"name": one, "max_input_channels": 1, "hostapi": 0} for one in self._names]
        if name is not None:
            return {"index": self._names.index(name)}
        if self._default is None:
            raise ValueError("Error querying device -1")
        return {"name": self._default}

    def query_hostapis(self, number: int) -> dict[str, str]:
        return {"name": "ALSA"}


@pytest.mark.parametrize(
    ("sounds", "source"),
    [
        (Sounds("Webcam", "USB", default="USB"), "microphone"),
        (Sounds("Webcam", "USB"), "microphone:Webcam"),
        (Sounds(), None),
    ],
)
def test_the_default_microphone_else_the_first(sounds: Sounds, source: str | None) -> None:
    """The default microphone is chosen, else the first, else none; the log says which."""
    with capture_logs() as logs:
        found = first_microphone(load_portaudio=lambda: sounds)
    assert (None if found is None else found.source) == source
    assert len(logs) == 1


def auto(robot: IdleRobot) -> find_sources.Sources:
    return make_sources(DrivingViewSettings(), AudioSettings(), SystemClock(), robot)


def test_what_nobody_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """The defaults use the robot's own devices, or else what is found."""
    seeing = auto(SeeingRobot())
    assert isinstance(seeing.video, TestCardVideo)
    assert isinstance(seeing.audio, TestCardAudio)
    monkeypatch.setattr(
        find_sources, "first_microphone", lambda: device("microphone:3", "USB microphone")
    )
    blind = auto(IdleRobot())
    assert isinstance(blind.video, FirstCamera)
    assert isinstance(blind.audio, PortAudioMicrophone)
    monkeypatch.setattr(find_sources, "first_microphone", lambda: None)
    assert auto(IdleRobot()).audio is None


def test_it_is_the_source_of_the_listed_name() -> None:
    """A found device is built as if it had been configured by its listed name."""
    camera = auto(IdleRobot()).video
    assert isinstance(camera, FirstCamera)
    assert isinstance(camera._make("rtsp://127.0.0.1:1/eye"), FileVideo)


def test_a_further_camera_must_be_named() -> None:
    """The value "auto" is possible for the driving view only."""
    with pytest.raises(ConfigError, match=r"only \[video\] takes what it finds"):
        config.parse({"camera": [{"name": "Door", "source": "auto"}]}, "robot.toml")
