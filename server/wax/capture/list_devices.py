"""List this machine's cameras, microphones and speakers, as written in the configuration.

Each device is listed by a lasting name, because numbers change as other devices are plugged in.
"""

from __future__ import annotations

import importlib
import re
import struct
import sys
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from wax.capture.camera import VideoDevice, open_device
from wax.capture.picamera import load_picamera2
from wax.capture.portaudio import SOUND_CARDS, load_portaudio, portaudio_name
from wax.capture.v4l2_controls import list_controls
from wax.errors import SourceError
from wax.lasting_names import lasting_name, links

if TYPE_CHECKING:
    from collections.abc import Callable

_VIDIOC_QUERYCAP: Final = 0x80685600
_QUERYCAP_BYTES: Final = 104
_DEVICE_CAPS_OFFSET: Final = 88
_CAN_CAPTURE: Final = 0x1
"""V4L2_CAP_VIDEO_CAPTURE (linux/videodev2.h)."""

_NOT_PICTURES: Final = (b"unicam", b"bcm2835-isp", b"rp1-cfe", b"pispbe")
"""Drivers of a Raspberry Pi's camera module whose nodes only libcamera can use."""

_PROBED: Final = 5


@dataclass(frozen=True, slots=True)
class ListedDevice:
    """A device: `source` is the value for the configuration key `key`, `name` its own name."""

    key: str
    source: str
    name: str

    def __str__(self) -> str:
        return f'{self.key} = "{self.source}"   # {self.name}'


def list_devices() -> list[str]:
    """Return printable lines: each camera, microphone and speaker, or why there is none."""
    cameras = list_cameras()
    lines = ["Cameras:"]
    for camera in cameras:
        lines.append(f"  {camera}")
        if camera.source.startswith("/dev/") and (controls := list_controls(camera.source)):
            lines += [
                "    which can be set in [video.controls], now:",
                *(f"      {one}" for one in controls),
            ]
    lines += [] if cameras else ["  none found"]
    for heading, listed in (("Microphones:", list_microphones), ("Speakers:", list_speakers)):
        devices, problem = listed()
        lines += [heading, *(f"  {device}" for device in devices)]
        if problem is not None or not devices:
            lines.append(f"  {problem or 'none found'}")
    return lines


def list_cameras(
    *,
    sysfs: Path = Path("/sys/class/video4linux"),
    dev: Path = Path("/dev"),
    probe: Callable[[int | str], VideoDevice] | None = None,
) -> list[ListedDevice]:
    """List V4L2's cameras, or on other systems the numbers from 0 to 4 that open."""
    if sys.platform.startswith("linux") and probe is None:
        return [*list_modules(), *_v4l2_cameras(sysfs, dev)]
    found = []
    for number in range(_PROBED):
        device = (probe or open_device)(number)
        if device.isOpened():
            found.append(ListedDevice("[video] source", str(number), f"camera {number}"))
        device.release()
    return found


def list_modules(load: Callable[[], Any] = load_picamera2) -> list[ListedDevice]:
    """List the camera modules that libcamera finds; none if picamera2 is missing.

    USB cameras, which libcamera finds, too, are left out: V4L2 lists them already.
    """
    try:
        there = load().global_camera_info()
    except Exception:  # picamera2, libcamera or a system library is missing or broken
        return []
    return [
        ListedDevice("[video] source", f"picamera:{number}", str(one.get("Model", "camera module")))
        for number, one in enumerate(there)
        if "usb" not in str(one.get("Id", ""))
    ]


def _v4l2_cameras(sysfs: Path, dev: Path) -> list[ListedDevice]:
    """List the nodes that deliver pictures, not metadata, by their names in sysfs."""
    nodes = sorted(sysfs.glob("video*"), key=lambda node: (len(node.name), node.name))
    found = [
        (str(dev / node.name), _text(node / "name") or node.name)
        for node in nodes
        if _can_capture(dev / node.name)
    ]
    alike = Counter(name for _, name in found)
    return [
        ListedDevice(
            "[video] source",
            lasting_name(path, dev / "v4l", has_twin=alike[name] > 1),
            name,
        )
        for path, name in found
    ]


def _can_capture(path: Path) -> bool:
    """Return whether a V4L2 node captures video; True for a node that cannot be opened."""
    fcntl = importlib.import_module("fcntl")  # exists wherever V4L2 does
    answer = bytearray(_QUERYCAP_BYTES)
    try:
        with path.open("rb", buffering=0) as node:
            fcntl.ioctl(node, _VIDIOC_QUERYCAP, answer)
    except OSError as error:
        return not isinstance(error, FileNotFoundError)
    if bytes(answer[:16]).rstrip(b"\0") in _NOT_PICTURES:
        return False
    (capabilities,) = struct.unpack_from("=I", answer, _DEVICE_CAPS_OFFSET)
    return bool(capabilities & _CAN_CAPTURE)


def list_microphones(
    *, load_portaudio: Callable[[], Any] = load_portaudio
) -> tuple[list[ListedDevice], str | None]:
    """List the microphones that PortAudio knows, and a sentence if it is missing."""
    return _sound_devices(load_portaudio, "[audio] source", "microphone", "max_input_channels")


def list_speakers(
    *, load_portaudio: Callable[[], Any] = load_portaudio
) -> tuple[list[ListedDevice], str | None]:
    """List the speakers that PortAudio knows, and a sentence if it is missing."""
    return _sound_devices(load_portaudio, "[voice] speaker", "speaker", "max_output_channels")


def _sound_devices(
    load_portaudio: Callable[[], Any], key: str, kind: str, channels: str
) -> tuple[list[ListedDevice], str | None]:
    found = []
    problem = None
    try:
        portaudio = load_portaudio()
        for number, entry in enumerate(portaudio.query_devices()):
            if entry[channels] > 0:
                host = portaudio.query_hostapis(entry["hostapi"])["name"]
                name = _name_of(portaudio, number, entry["name"], channels.split("_")[1])
                found.append(ListedDevice(key, f"{kind}:{name}", f"{entry['name']} ({host})"))
    except SourceError as error:
        problem = str(error)
    except Exception as error:  # PortAudio's own errors, without a sound system
        problem = f"PortAudio cannot list its devices: {error}"
    return found, problem


def _name_of(portaudio: Any, number: int, full: str, way: str) -> str:
    """Return the most lasting name by which PortAudio finds this device and no other.

    That is its own name without the number that ALSA adds in brackets; for one of two identical
    devices the sound card's socket, else its ALSA number; failing these, PortAudio's number.
    """
    names = [full.split(" (", maxsplit=1)[0].strip(), full]
    if card := re.search(r"hw:(\d+),\d+", full):
        socket = links(SOUND_CARDS / "by-path").get(str(SOUND_CARDS / f"controlC{card[1]}"))
        names[1:] = [socket or card[0], card[0]]
    for name in names:
        if name.isprintable() and not name.isdecimal() and not set(name) & set('"\\'):
            with suppress(Exception):  # PortAudio's error, where it finds none or several
                if portaudio.query_devices(portaudio_name(name), way)["index"] == number:
                    return name
    return str(number)


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8", errors="replace").strip()
    except OSError:
        return ""
