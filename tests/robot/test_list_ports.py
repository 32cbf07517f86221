"""Listing serial ports."""

from __future__ import annotations

from typing import TYPE_CHECKING

from serial.tools import list_ports as tools
from serial.tools.list_ports_common import ListPortInfo

from wax.robot.serial.list_ports import find_ports, list_ports

if TYPE_CHECKING:
    import pytest


def port(device: str, description: str) -> ListPortInfo:
    info = ListPortInfo(device)
    info.description = description
    return info


def test_each_port_is_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ports are listed in order, with what is known about them."""
    found = [port("/dev/ttyUSB1", "n/a"), port("/dev/ttyACM0", "Arduino Uno")]
    monkeypatch.setattr(tools, "comports", lambda: found)
    assert list_ports() == ["Serial ports:", "  /dev/ttyACM0  (Arduino Uno)", "  /dev/ttyUSB1"]


def test_none_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine without a serial port says so."""
    monkeypatch.setattr(tools, "comports", list)
    assert list_ports() == ["Serial ports:", "  none found"]


def test_boards_that_say_the_same_of_themselves_are_twins(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two without a number of their own are; two with different ones, or no USB, are not."""
    found = []
    for device, vid, serial in (
        ("/dev/ttyACM0", 1, "A"),
        ("/dev/ttyACM1", 1, "B"),
        ("/dev/ttyS0", None, None),
        ("/dev/ttyS1", None, None),
        ("/dev/ttyUSB0", 1, None),
        ("/dev/ttyUSB1", 1, None),
    ):
        one = port(device, "n/a")
        one.vid, one.serial_number = vid, serial
        found.append(one)
    monkeypatch.setattr(tools, "comports", lambda: found)
    assert [one.path for one in find_ports() if one.has_twin] == ["/dev/ttyUSB0", "/dev/ttyUSB1"]
