"""What a device is called for good: udev's links, for numbers change as things are plugged in."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path


def lasting_name(device: str, folder: Path, *, has_twin: bool) -> str:
    """Return the link in `folder` that names the device by what it is, else the device.

    Two that say the same of themselves claim one such link, which leads to whichever was found
    last: of one that `has_twin` it is the link that names the socket that it is in.
    """
    return links(folder / ("by-path" if has_twin else "by-id")).get(device, device)


def links(folder: Path) -> dict[str, str]:
    """Return the links there, the first by name, by the device to which they lead now."""
    found = sorted(folder.iterdir()) if folder.is_dir() else []
    return {str(link.resolve()): str(link) for link in reversed(found)}
