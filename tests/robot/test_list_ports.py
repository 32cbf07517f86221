"""Listing serial ports."""

from __future__ import annotations

from typing import TYPE_CHECKING

from serial.tools import list_ports as tools
from serial.tools.list_ports_common import ListPortInfo

from wax.robot.serial.list_ports import list_ports

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
