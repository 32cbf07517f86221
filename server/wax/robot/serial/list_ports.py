"""List this machine's serial ports, for `wax devices` and `wax init`."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from serial.tools import list_ports as tools


@dataclass(frozen=True, slots=True)
class Port:
    """A serial port; what is `about` it may be nothing.

    `has_twin` is whether another says the same of itself, so that only its socket tells it apart.
    """

    path: str
    about: str
    is_usb: bool
    has_twin: bool = False


def find_ports() -> list[Port]:
    """Return each serial port, in the order of their names."""
    found = sorted(tools.comports(), key=lambda port: port.device)
    # Cheap boards have no serial number of their own, or all the same one.
    alike = Counter((one.vid, one.pid, one.serial_number, one.interface) for one in found)
    return [
        Port(
            one.device,
            _about(one.description),
            is_usb=one.vid is not None,
            has_twin=one.vid is not None
            and alike[one.vid, one.pid, one.serial_number, one.interface] > 1,
        )
        for one in found
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
