"""Listing serial ports."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from serial.tools import list_ports as tools
from serial.tools.list_ports_common import ListPortInfo

from wax.robot.serial.list_ports import ListedPort, find_ports, list_ports, safer_name

if TYPE_CHECKING:
    from pathlib import Path


def port(device: str, description: str) -> ListPortInfo:
    info = ListPortInfo(device)
    info.description = description
    return info


def test_each_port_is_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ports are listed in order, with what is known about them."""
    found = [port("/dev/ttyUSB1", "n/a"), port("/dev/ttyACM0", "Arduino Uno")]
    monkeypatch.setattr(tools, "comports", lambda: found)
    assert list_ports() == ["Serial ports:", "  /dev/ttyACM0  (Arduino Uno)", "  /dev/ttyUSB1"]


def test_no_port_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine without a serial port says so."""
    monkeypatch.setattr(tools, "comports", list)
    assert list_ports() == ["Serial ports:", "  none found"]


def test_boards_with_the_same_identity_are_named_by_their_sockets(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The by-id link that they share leads to whichever board was found last."""
    found = []
    for number, (name, vid, serial) in enumerate(
        (("A", 1, "A"), ("B", 1, "B"), ("S", None, None), ("S", None, None), *[("", 1, None)] * 2)
    ):
        node = tmp_path / f"tty{number}"
        node.touch()
        for folder, link in (("by-id", f"usb-{name}"), ("by-path", f"hub-{number}")):
            (tmp_path / folder).mkdir(exist_ok=True)
            (tmp_path / folder / link).unlink(missing_ok=True)
            (tmp_path / folder / link).symlink_to(node)
        one = port(str(node), "n/a")
        one.vid, one.serial_number = vid, serial
        found.append(one)
    monkeypatch.setattr(tools, "comports", lambda: found)
    names = [one.name.removeprefix(f"{tmp_path}/") for one in find_ports(tmp_path) if one.is_usb]
    assert names == ["by-id/usb-A", "by-id/usb-B", "by-path/hub-4", "by-path/hub-5"]


@pytest.mark.parametrize(
    ("url", "others", "safer"),
    [
        ("tty0", 1, "by-path/hub-0"),
        ("by-id/usb", 1, "by-path/hub-0"),
        ("by-path/hub-0", 1, None),
        ("rover", 1, None),
        ("tty0", 0, None),
        ("socket://host:1", 1, None),
    ],
)
def test_a_safer_name_is_suggested(
    tmp_path: Path, url: str, others: int, safer: str | None
) -> None:
    """With two boards, a device number or their common link is unsafe; other links are not."""
    (tmp_path / "tty0").touch()
    for link in ("by-id/usb", "by-path/hub-0", "rover"):
        (tmp_path / link).parent.mkdir(exist_ok=True)
        (tmp_path / link).symlink_to(tmp_path / "tty0")
    ports = [
        ListedPort(
            f"{tmp_path}/by-path/hub-{one}", f"{tmp_path}/tty{one}", "", is_usb=True, has_twin=True
        )
        for one in range(1 + others)
    ]
    written = url if "://" in url else f"{tmp_path}/{url}"
    assert safer_name(written, ports) == (safer and f"{tmp_path}/{safer}")
