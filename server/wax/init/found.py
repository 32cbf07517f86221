"""What is plugged in, named as it stays when things are plugged in again."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from wax.capture.list_devices import list_cameras, list_microphones, list_speakers
from wax.plugin import DRIVERS, offers
from wax.robot.serial.list_ports import Port, find_ports

if TYPE_CHECKING:
    from collections.abc import Iterable

    from wax.capture.list_devices import Device

_ASKED: Final = frozenset({"serial", "simulated"})
"""Drivers that are choices of their own."""


@dataclass(frozen=True, slots=True)
class Thing:
    """Something that is there: `source` is what to write for it, `name` what it calls itself."""

    source: str
    name: str


@dataclass(frozen=True, slots=True)
class Found:
    """All that is there; `ports` has those first that something was plugged into.

    `plugged` says how many these are. `drivers` are plug-ins by their names, those that have
    all they need.
    """

    cameras: tuple[Thing, ...] = ()
    microphones: tuple[Thing, ...] = ()
    speakers: tuple[Thing, ...] = ()
    ports: tuple[Thing, ...] = ()
    plugged: int = 0
    drivers: tuple[str, ...] = ()


def look() -> Found:
    """Look at this machine. Nothing is opened that could move."""
    ports = find_ports()
    plugged = [port for port in ports if port.is_usb]
    others = [port for port in ports if not port.is_usb]
    return Found(
        cameras=_cameras(),
        microphones=_by_name(list_microphones()[0], "microphone"),
        speakers=_by_name(list_speakers()[0], "speaker"),
        ports=_ports((*plugged, *others), Path("/dev/serial")),
        plugged=len(plugged),
        drivers=tuple(sorted({one.name for one in offers(DRIVERS) if not one.lacks} - _ASKED)),
    )


def _ports(ports: Iterable[Port], folder: Path) -> tuple[Thing, ...]:
    """Name each by what it is; of two alike, which share that name, by the socket it is in."""
    by_id, by_path = lasting_names(folder / "by-id"), lasting_names(folder / "by-path")
    return tuple(
        Thing((by_path if one.has_twin else by_id).get(one.path, one.path), one.about)
        for one in ports
    )


def _cameras() -> tuple[Thing, ...]:
    lasting = lasting_names(Path("/dev/v4l/by-id"))
    return tuple(Thing(lasting.get(one.source, one.source), one.name) for one in list_cameras())


def lasting_names(folder: Path) -> dict[str, str]:
    """Return the links there by the device they lead to now: numbers change, these do not."""
    links = sorted(folder.iterdir()) if folder.is_dir() else []
    return {str(link.resolve()): str(link) for link in reversed(links)}


def _by_name(devices: list[Device], kind: str) -> tuple[Thing, ...]:
    """Name sound devices by their names, since their numbers change; by number if two are alike.

    PortAudio adds the system, and the card's number, in brackets; it finds a part of the name.
    """
    short = [one.name.split(" (")[0].strip() for one in devices]
    return tuple(
        Thing(
            f"{kind}:{name}" if _is_one(name, devices) else device.source,
            device.name,
        )
        for name, device in zip(short, devices, strict=True)
    )


def _is_one(name: str, devices: list[Device]) -> bool:
    alike = sum(name.lower() in one.name.lower() for one in devices)
    return bool(name) and not name.isdecimal() and alike == 1
