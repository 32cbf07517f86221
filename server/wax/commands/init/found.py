"""Detects what is plugged in, under names that survive replugging."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from wax.capture.list_devices import ListedDevice, list_cameras, list_microphones, list_speakers
from wax.plugin import DRIVERS, offers
from wax.robot.serial.list_ports import find_ports

_ASKED: Final = frozenset({"serial", "simulated"})
"""Drivers that are offered as choices of their own."""


@dataclass(frozen=True, slots=True)
class Thing:
    """A device: `source` is its value in the configuration, `name` its name for itself."""

    source: str
    name: str


@dataclass(frozen=True, slots=True)
class Found:
    """All devices found; the first `plugged` of `ports` have something plugged in.

    `drivers` are the names of the plug-ins whose requirements are installed.
    """

    cameras: tuple[Thing, ...] = ()
    microphones: tuple[Thing, ...] = ()
    speakers: tuple[Thing, ...] = ()
    ports: tuple[Thing, ...] = ()
    plugged: int = 0
    drivers: tuple[str, ...] = ()


def detect() -> Found:
    """Detect this machine's devices, without opening anything that could move."""
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
