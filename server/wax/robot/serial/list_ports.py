"""List this machine's serial ports, for `wax devices`."""

from __future__ import annotations

from serial.tools import list_ports as tools


def list_ports() -> list[str]:
    """Return printable lines: each serial port with its description, or that there is none."""
    found = sorted(tools.comports(), key=lambda port: port.device)
    lines = [f"  {port.device}{_about(port.description)}" for port in found]
    return ["Serial ports:", *(lines or ["  none found"])]


def _about(description: str | None) -> str:
    return f"  ({description})" if description and description != "n/a" else ""
