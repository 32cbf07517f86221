"""What is found is named as it stays: links and names rather than numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.capture.list_devices import Device
from wax.init.found import _by_name, lasting_names, look

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
