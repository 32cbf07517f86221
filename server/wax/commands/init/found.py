"""What is plugged in, named as it stays when things are plugged in again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from wax.capture.list_devices import ListedDevice, list_cameras, list_microphones, list_speakers
from wax.plugin import DRIVERS, offers
from wax.robot.serial.list_ports import find_ports

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
        cameras=_things(list_cameras()),
        microphones=_things(list_microphones()[0]),
        speakers=_things(list_speakers()[0]),
        ports=tuple(Thing(one.name, one.about) for one in (*plugged, *others)),
        plugged=len(plugged),
        drivers=tuple(sorted({one.name for one in offers(DRIVERS) if not one.lacks} - _ASKED)),
    )


def _things(devices: list[ListedDevice]) -> tuple[Thing, ...]:
    return tuple(Thing(one.source, one.name) for one in devices)
