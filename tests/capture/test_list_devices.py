"""`wax devices`: lists devices as the configuration names them, and never fails."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from wax.capture import list_devices as devices
from wax.capture import portaudio
from wax.capture.list_devices import ListedDevice, list_cameras, list_devices, list_microphones
from wax.errors import SourceError

if TYPE_CHECKING:
    from pathlib import Path


class Probe:
    """A capture device that opens or does not."""

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
    """PortAudio's queries; a name matches exactly or, failing that, as a part."""

    def __init__(self, *names: str) -> None:
        self._names = names or ("USB Webcam",)

    def query_devices(self, name: str | None = None, way: str = "input") -> Any:
        hdmi = {"name": "HDMI", "max_input_channels": 0, "hostapi": 0}
        one = {"max_input_channels": 1, "hostapi": 0}
        if name is None:
            return [hdmi, *({**one, "name": each} for each in self._names)]
        assert way == "input"
        parts = [at for at, each in enumerate(self._names, 1) if name.lower() in each.lower()]
        whole = [at for at, each in enumerate(self._names, 1) if name.lower() == each.lower()]
        (found,) = parts if len(parts) == 1 else whole
        return {"index": found}

    def query_hostapis(self, number: int) -> dict[str, str]:
        return {"name": "ALSA"}


def no_library() -> None:
    raise SourceError("Install libportaudio2.")


def test_v4l2_names(tmp_path: Path) -> None:
    """Cameras are listed by number with the kernel's name; unplugged ones are not."""
    for number, name in ((10, "Thermal"), (2, "HD Webcam"), (3, "gone")):
        (tmp_path / "sys" / f"video{number}").mkdir(parents=True)
        (tmp_path / "sys" / f"video{number}" / "name").write_text(f"{name}\n")
    (tmp_path / "dev").mkdir()
    for number in (2, 10):  # nodes that cannot be queried are listed: better one too many
        (tmp_path / "dev" / f"video{number}").write_bytes(b"")
    found = devices._v4l2_cameras(tmp_path / "sys", tmp_path / "dev")
    assert [(device.source, device.name) for device in found] == [
        (f"{tmp_path}/dev/video2", "HD Webcam"),
        (f"{tmp_path}/dev/video10", "Thermal"),
    ]


def test_two_cameras_of_one_name_are_named_by_their_sockets(tmp_path: Path) -> None:
    """Cameras of one model are listed by socket, since they share one link in by-id."""
    for number, name in ((0, "Acme"), (2, "Acme"), (4, "Thermal")):
        (tmp_path / "sys" / f"video{number}").mkdir(parents=True)
        (tmp_path / "sys" / f"video{number}" / "name").write_text(name)
        for folder, link in (("by-id", f"usb-{name}"), ("by-path", f"hub-{number}")):
            (tmp_path / "v4l" / folder).mkdir(parents=True, exist_ok=True)
            (tmp_path / "v4l" / folder / link).unlink(missing_ok=True)
            (tmp_path / "v4l" / folder / link).symlink_to(tmp_path / f"video{number}")
        (tmp_path / f"video{number}").touch()
    found = devices._v4l2_cameras(tmp_path / "sys", tmp_path)
    names = [one.source.removeprefix(f"{tmp_path}/v4l/") for one in found]
    assert names == ["by-path/hub-0", "by-path/hub-2", "by-id/usb-Thermal"]


@pytest.mark.parametrize(("capabilities", "listed"), [(0x04200001, 1), (0x04A00000, 0)])
def test_metadata_nodes_are_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capabilities: int, listed: int
) -> None:
    """A node that cannot capture video, as each webcam has one, is not listed."""
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
    """Without V4L2 the numbers 0 to 4 are opened, listed if they open, and released."""
    probes = [Probe(opens=number == 1) for number in range(5)]
    found = list_cameras(probe=lambda number: probes[int(number)])
    assert [str(device) for device in found] == ['[video] source = "1"   # camera 1']
    assert all(probe.released for probe in probes)


def test_microphones_are_inputs() -> None:
    """PortAudio's inputs are listed with their host API; outputs are not."""
    found, problem = list_microphones(load_portaudio=Sounds)
    assert problem is None
    assert found == [ListedDevice("[audio] source", "microphone:USB Webcam", "USB Webcam (ALSA)")]


def test_sound_devices_are_named_by_what_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A device is listed by name if that is unique, else by socket, else by number."""
    monkeypatch.setattr(devices, "SOUND_CARDS", tmp_path)
    monkeypatch.setattr(portaudio, "SOUND_CARDS", tmp_path)
    (tmp_path / "by-path").mkdir()
    (tmp_path / "controlC3").touch()
    socket = tmp_path / "by-path" / "usb-0:1:1.0"
    socket.symlink_to(tmp_path / "controlC3")
    names = {
        "Jabra: USB Audio (hw:2,0)": "Jabra: USB Audio",
        "Webcam: A (hw:1,0)": "hw:1,0",
        "Webcam: A (hw:3,0)": str(socket),
        "default": "default",
        "sysdefault": "sysdefault",
        "Microphone (Realtek)": "Microphone (Realtek)",
        "Microphone (USB)": "Microphone (USB)",
        "7": "8",  # the eighth
        'the "good" one': "9",
    }
    found, _ = list_microphones(load_portaudio=lambda: Sounds(*names))
    sources = [one.source.removeprefix("microphone:") for one in found]
    assert sources == list(names.values())


def test_a_missing_library_is_said() -> None:
    """Without PortAudio the list says what to install."""
    assert list_microphones(load_portaudio=no_library) == ([], "Install libportaudio2.")


def test_it_works_on_this_machine() -> None:
    """On any machine there are lines for all kinds and no exception."""
    lines = list_devices()
    assert lines[0] == "Cameras:"
    assert "Microphones:" in lines
    assert "Speakers:" in lines
    assert len(lines) >= 6
