"""What is found is named as it stays: links and names rather than numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.capture.list_devices import Device
from wax.init.found import _by_name, _ports, lasting_names, look
from wax.robot.serial.list_ports import Port

if TYPE_CHECKING:
    from pathlib import Path


def test_links_are_found_by_what_they_lead_to(tmp_path: Path) -> None:
    """Of several links to one device the first by name is taken; no folder has none."""
    node = tmp_path / "video0"
    node.write_bytes(b"")
    folder = tmp_path / "by-id"
    assert lasting_names(folder) == {}
    folder.mkdir()
    for name in ("usb-b", "usb-a"):
        (folder / name).symlink_to(node)
    assert lasting_names(folder) == {str(node): str(folder / "usb-a")}


def test_sound_devices_have_names_unless_two_are_alike() -> None:
    """A name that PortAudio would find twice, or that is a number, is no name."""
    names = ("Jabra: USB Audio (hw:2,0)", "Webcam: A (hw:1,0)", "Webcam: A (hw:3,0)", "7 (ALSA)")
    devices = [Device("k", f"microphone:{number}", name) for number, name in enumerate(names)]
    assert [one.source for one in _by_name(devices, "microphone")] == [
        "microphone:Jabra: USB Audio",
        "microphone:1",
        "microphone:2",
        "microphone:3",
    ]


def test_it_looks_at_this_machine() -> None:
    """Whatever is here, it is found without an exception, and our own drivers are no plug-ins."""
    found = look()
    assert found.plugged <= len(found.ports)
    assert not {"serial", "simulated"} & set(found.drivers)


def test_two_boards_that_say_the_same_are_named_by_their_sockets(tmp_path: Path) -> None:
    """The one link that both would have leads to whichever was found last, also to the other."""
    for folder, name, device in (
        ("by-id", "usb-1a86", "ttyUSB1"),
        ("by-id", "usb-uno", "ttyACM0"),
        ("by-path", "hub-1", "ttyUSB0"),
        ("by-path", "hub-2", "ttyUSB1"),
        ("by-path", "hub-3", "ttyACM0"),
    ):
        (tmp_path / device).touch()
        (tmp_path / folder).mkdir(exist_ok=True)
        (tmp_path / folder / name).symlink_to(tmp_path / device)
    ports = [
        Port(str(tmp_path / device), "", is_usb=True, has_twin=device != "ttyACM0")
        for device in ("ttyACM0", "ttyUSB0", "ttyUSB1")
    ]
    names = [one.source for one in _ports(ports, tmp_path)]
    assert [name.removeprefix(f"{tmp_path}/") for name in names] == [
        "by-id/usb-uno",
        "by-path/hub-1",
        "by-path/hub-2",
    ]
