"""Devices are named by stable links, not by numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.lasting_names import lasting_name, links

if TYPE_CHECKING:
    from pathlib import Path


def test_links_are_found_by_what_they_lead_to(tmp_path: Path) -> None:
    """Of several links to a device, the first by name counts; a missing folder has none."""
    node = tmp_path / "video0"
    node.write_bytes(b"")
    folder = tmp_path / "by-id"
    assert links(folder) == {}
    folder.mkdir()
    for name in ("usb-b", "usb-a"):
        (folder / name).symlink_to(node)
    assert links(folder) == {str(node): str(folder / "usb-a")}


def test_one_of_two_alike_is_called_by_its_socket(tmp_path: Path) -> None:
    """Of two devices with one id, each is named by its port; without links, by its number."""
    node = tmp_path / "ttyUSB1"
    node.touch()
    assert lasting_name(str(node), tmp_path, has_twin=True) == str(node)
    for folder, name in (("by-id", "usb-1a86"), ("by-path", "hub-2")):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / name).symlink_to(node)
    names = [lasting_name(str(node), tmp_path, has_twin=twin) for twin in (False, True)]
    assert names == [f"{tmp_path}/by-id/usb-1a86", f"{tmp_path}/by-path/hub-2"]
