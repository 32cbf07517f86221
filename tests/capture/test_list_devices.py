"""`wax devices`: lists what is there as it is written in the configuration, and never fails."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from wax.capture import list_devices as devices
from wax.capture.list_devices import Device, list_cameras, list_devices, list_microphones
from wax.errors import SourceError

if TYPE_CHECKING:
    from pathlib import Path


class Probe:
    """A capture that opens or not."""

    def __init__(self, *, opens: bool) -> None:
        self.opens = opens
        self.released = False

    def isOpened(self) -> bool:  # noqa: N802 - OpenCV's name
        return self.opens

    def set(self, propId: int, value: float, /) -> bool:  # noqa: N803 - OpenCV's name
        return False

    def grab(self) -> bool:
        return False

    def retrieve(self) -> tuple[bool, Any]:
        return False, None

    def release(self) -> None:
        self.released = True


class Sounds:
    """PortAudio's two questions."""

    def query_devices(self) -> list[dict[str, Any]]:
        return [
            {"name": "HDMI", "max_input_channels": 0, "hostapi": 0},
            {"name": "USB Webcam", "max_input_channels": 1, "hostapi": 0},
        ]

    def query_hostapis(self, number: int) -> dict[str, str]:
        return {"name": "ALSA"}


def no_library() -> None:
    raise SourceError("Install libportaudio2.")


def test_v4l2_names(tmp_path: Path) -> None:
    """Cameras are listed by number with the name that the kernel knows; vanished ones are not."""
    for number, name in ((10, "Thermal"), (2, "HD Webcam"), (3, "gone")):
        (tmp_path / "sys" / f"video{number}").mkdir(parents=True)
        (tmp_path / "sys" / f"video{number}" / "name").write_text(f"{name}\n")
    (tmp_path / "dev").mkdir()
    for number in (2, 10):  # files that cannot be asked are listed: better one too many
        (tmp_path / "dev" / f"video{number}").write_bytes(b"")
    found = devices._v4l2_cameras(tmp_path / "sys", tmp_path / "dev")
    assert [(device.source, device.name) for device in found] == [
        (f"{tmp_path}/dev/video2", "HD Webcam"),
        (f"{tmp_path}/dev/video10", "Thermal"),
    ]


@pytest.mark.parametrize(("capabilities", "listed"), [(0x04200001, 1), (0x04A00000, 0)])
def test_metadata_nodes_are_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capabilities: int, listed: int
) -> None:
    """A node that the kernel says cannot capture video, as each webcam has one, is not listed."""
    (tmp_path / "video0").mkdir()
    (tmp_path / "dev").mkdir()
    (tmp_path / "dev" / "video0").write_bytes(b"")

    def ioctl(node: object, request: int, answer: bytearray) -> int:
        assert request == 0x80685600
        answer[88:92] = capabilities.to_bytes(4, "little")
        return 0

    monkeypatch.setattr("fcntl.ioctl", ioctl)
    assert len(devices._v4l2_cameras(tmp_path, tmp_path / "dev")) == listed


def test_elsewhere_numbers_are_tried() -> None:
    """Without V4L2 the numbers 0 to 4 are opened, listed if that works, and let go."""
    probes = [Probe(opens=number == 1) for number in range(5)]
    found = list_cameras(probe=lambda number: probes[int(number)])
    assert [str(device) for device in found] == ['[video] source = "1"   # camera 1']
    assert all(probe.released for probe in probes)


def test_microphones_are_inputs() -> None:
    """PortAudio's inputs are listed with the system that they belong to; outputs are not."""
    found, problem = list_microphones(load_portaudio=Sounds)
    assert problem is None
    assert found == [Device("[audio] source", "microphone:1", "USB Webcam (ALSA)")]


def test_a_missing_library_is_said() -> None:
    """Without PortAudio the list says what to install."""
    assert list_microphones(load_portaudio=no_library) == ([], "Install libportaudio2.")


def test_it_works_on_this_machine() -> None:
    """Whatever this machine has or lacks, there are lines for all kinds and no exception."""
    lines = list_devices()
    assert lines[0] == "Cameras:"
    assert "Microphones:" in lines
    assert "Speakers:" in lines
    assert len(lines) >= 6
