"""Picks the first camera or microphone for `source = "auto"` if the robot has none of its own."""

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
    """Opens the first camera that is listed; once one has opened, only ever that camera.

    Another camera looks elsewhere, and the driving view must not switch to it: when the chosen one
    is unplugged, opening fails until it is back. While no camera is listed, each `open` looks
    again. `taken` are the sources of the other cameras; `make` builds a source from its name.
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
        """The chosen camera's source, for people."""
        return "auto" if self._device is None else str(self._device.source)

    @property
    def rest_s(self) -> float | None:
        return getattr(self._source, "rest_s", None)

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
        # Match by name, because a camera often has another number after it is plugged in again; but
        # where two cameras share a name, only the socket tells them apart.
        same = [one for one in found if one.name == self._device.name]
        exact = next((one for one in same if one.source == self._device.source), None)
        if exact is not None:
            return exact
        if self._has_twin or len(same) != 1:
            raise SourceError(Sentence("camera.gone", {"camera": self._device.name}))
        return same[0]


def first_camera(
    taken: Iterable[str], *, list_cameras: Callable[[], list[ListedDevice]] = list_cameras
) -> str | None:
    """Return the source that `FirstCamera` would choose now, None if that takes opening cameras."""
    if not sys.platform.startswith("linux"):
        return None
    nodes = {_node(one) for one in taken}
    there = (one.source for one in list_cameras())
    return next((one for one in there if _node(one) not in nodes), None)


def first_microphone(*, load_portaudio: Callable[[], Any] = load_portaudio) -> ListedDevice | None:
    """Return the default microphone, else the first; log and return None if there is none."""
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
    except Exception:  # PortAudio's own errors, where the system has no default
        return None
    return ListedDevice("[audio] source", "microphone", str(name))


def _node(source: str) -> str:
    """Return what identifies a camera under all its names: its device node if it has one."""
    device = source.removeprefix("camera:")
    if device.isdecimal() and sys.platform.startswith("linux"):
        device = f"/dev/video{device}"
    return os.path.realpath(device) if device.startswith("/") else device
