"""Stable device names: udev's links, since device numbers change as devices are plugged in."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path


def lasting_name(device: str, folder: Path, *, has_twin: bool) -> str:
    """Return the stable link in `folder` to a device, or the device if it has none.

    That is its link by id. Two devices with the same id share one link, which leads to the one
    found last; a device that `has_twin` is therefore named by the port that it is plugged into.
    """
    return links(folder / ("by-path" if has_twin else "by-id")).get(device, device)


def links(folder: Path) -> dict[str, str]:
    """Return a folder's links by the device that each leads to, the first by name of several."""
    found = sorted(folder.iterdir()) if folder.is_dir() else []
    return {str(link.resolve()): str(link) for link in reversed(found)}
