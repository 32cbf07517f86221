"""`source = "auto"` where the robot has no camera or microphone of its own: the first found."""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING, Any

import structlog

from wax.capture.list_devices import ListedDevice, list_cameras, list_microphones
from wax.capture.portaudio import load_portaudio
from wax.errors import SourceError
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from wax.capture.source import Picture, VideoSource

_LOG = structlog.get_logger(__name__)


class FirstCamera:
    """The first camera that is listed when it is opened; once it has opened, always that one.

    Another one looks somewhere else, and nobody must suddenly drive by it: when the one that was
    taken has gone, this waits for it. While there is none, it keeps looking. `taken` are the
    sources of the cameras beside the driving view; `make` builds the source of a name.
    """

    def __init__(
        self,
        make: Callable[[str], VideoSource],
        *,
        taken: Iterable[str] = (),
        list_cameras: Callable[[], list[ListedDevice]] = list_cameras,
    ) -> None:
        self._make = make
        self._taken = frozenset(_node(one) for one in taken)
        self._list_cameras = list_cameras
        self._device: ListedDevice | None = None
        self._has_twin = False
        self._source: VideoSource | None = None

    @property
    def name(self) -> str:
        """What was taken, for people."""
        return "auto" if self._device is None else str(self._device.source)

    def open(self) -> None:
        self.close()
        device = self._find()
        self._source = self._make(device.source)
        self._source.open()
        if self._device is None:
            _LOG.info(
                "no camera is named, so the first one that was found is the driving view",
                camera=device.name,
                write=f'[video] source = "{device.source}"',
            )
        self._device = device

    def read(self) -> Picture:
        if self._source is None:
            raise SourceError("The camera was read before it was opened.")
        return self._source.read()

    def close(self) -> None:
        source, self._source = self._source, None
        if source is not None:
            source.close()

    def _find(self) -> ListedDevice:
        found = [one for one in self._list_cameras() if _node(one.source) not in self._taken]
        if self._device is None:
            if not found:
                raise SourceError(Sentence("camera.none_found"))
            self._has_twin = sum(one.name == found[0].name for one in found) > 1
            return found[0]
        # By its name, for a camera that was plugged in again often has another number; but where
        # two have one name, only the socket tells them apart.
        same = [one for one in found if one.name == self._device.name]
        exact = next((one for one in same if one.source == self._device.source), None)
        if exact is not None:
            return exact
        if self._has_twin or len(same) != 1:
            raise SourceError(Sentence("camera.gone", {"camera": self._device.name}))
        return same[0]


def first_microphone(*, load_portaudio: Callable[[], Any] = load_portaudio) -> ListedDevice | None:
    """Return the system's default microphone, else the first one, or None and say so."""
    found, problem = list_microphones(load_portaudio=load_portaudio)
    if not found:
        _LOG.warning(
            "no microphone was found, so there is no sound; plug one in and start again, or name"
            " one in [audio] source",
            why=problem or "PortAudio knows none",
        )
        return None
    device = _default_of(load_portaudio()) or found[0]
    _LOG.info(
        "no microphone is named, so the first one that was found is heard",
        microphone=device.name,
        write=f'[audio] source = "{device.source}"',
    )
    return device


def _default_of(portaudio: Any) -> ListedDevice | None:
    try:
        name = portaudio.query_devices(kind="input")["name"]
    except Exception:  # PortAudio's own errors, where the system has chosen none
        return None
    return ListedDevice("[audio] source", "microphone", str(name))


def _node(source: str) -> str:
    """Return what tells whether two names are one camera: the device node, where it has one."""
    device = source.removeprefix("camera:")
    if device.isdecimal() and sys.platform.startswith("linux"):
        device = f"/dev/video{device}"
    return os.path.realpath(device) if device.startswith("/") else device
