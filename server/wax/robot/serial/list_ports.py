"""List this machine's serial ports, for `wax devices` and `wax init`."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from serial.tools import list_ports as tools

from wax.lasting_names import lasting_name


@dataclass(frozen=True, slots=True)
class ListedPort:
    """A serial port; `about` is its description, which may be empty.

    `name` is the lasting name to configure, `path` the present device. `has_twin` says that another
    port has the same identity, so that only the USB socket tells them apart.
    """

    name: str
    path: str
    about: str
    is_usb: bool
    has_twin: bool = False


def find_ports(folder: Path = Path("/dev/serial")) -> list[ListedPort]:
    """Return each serial port, in the order of their names."""
    found = sorted(tools.comports(), key=lambda port: port.device)
    # Cheap boards have no serial number, or all have the same one.
    alike = Counter((one.vid, one.pid, one.serial_number, one.interface) for one in found)
    ports = []
    for one in found:
        is_usb = one.vid is not None
        twins = alike[one.vid, one.pid, one.serial_number, one.interface]
        has_twin = is_usb and twins > 1
        name = lasting_name(one.device, folder, has_twin=has_twin)
        about = _about(one.description)
        ports.append(ListedPort(name, one.device, about, is_usb=is_usb, has_twin=has_twin))
    return ports


def safer_name(url: str, ports: list[ListedPort]) -> str | None:
    """Return a lasting name if `url` may lead to another board after a restart.

    Device numbers follow the order of detection, and a link that two boards claim leads to the last
    of them.
    """
    here = str(Path(url).resolve())
    port = next((one for one in ports if one.is_usb and one.path == here), None)
    if port is None or port.name == port.path or sum(one.is_usb for one in ports) < 2:
        return None
    is_shared = port.has_twin and Path(url).parent.name == "by-id"
    return port.name if url == port.path or is_shared else None


def list_ports() -> list[str]:
    """Return lines to print: each serial port with its description, or that there is none."""
    lines = [
        f"  {port.name}  ({port.about})" if port.about else f"  {port.name}"
        for port in find_ports()
    ]
    return ["Serial ports:", *(lines or ["  none found"])]


def _about(description: str | None) -> str:
    return description if description and description != "n/a" else ""
