"""List this machine's serial ports, for `wax devices` and `wax init`."""

from __future__ import annotations

from dataclasses import dataclass

from serial.tools import list_ports as tools


@dataclass(frozen=True, slots=True)
class Port:
    """A serial port; what is `about` it may be nothing."""

    path: str
    about: str
    is_usb: bool


def find_ports() -> list[Port]:
    """Return each serial port, in the order of their names."""
    return [
        Port(one.device, _about(one.description), one.vid is not None)
        for one in sorted(tools.comports(), key=lambda port: port.device)
    ]


def list_ports() -> list[str]:
    """Return printable lines: each serial port with its description, or that there is none."""
    lines = [
        f"  {port.path}  ({port.about})" if port.about else f"  {port.path}"
        for port in find_ports()
    ]
    return ["Serial ports:", *(lines or ["  none found"])]


def _about(description: str | None) -> str:
    return description if description and description != "n/a" else ""
