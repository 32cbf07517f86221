"""Lists and sets a V4L2 camera's controls (exposure, focus …) by their names in `v4l2-ctl -l`.

Calls and structures are those of linux/videodev2.h, on a second descriptor of the camera: OpenCV
has only a few of the controls, by other names.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import re
import struct
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from wax.errors import SourceError, reason_of
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    Ioctl = Callable[[int, int, bytearray], object]

G_CTRL: Final = 0xC008561B
S_CTRL: Final = 0xC008561C
QUERYCTRL: Final = 0xC0445624
QUERYMENU: Final = 0xC02C5625
"""The request codes VIDIOC_…"""

CONTROL: Final = struct.Struct("=Ii")
QUERY: Final = struct.Struct("=II32siiiiI8x")
MENU: Final = struct.Struct("=II32s4x")
"""v4l2_control, v4l2_queryctrl and v4l2_querymenu."""

NEXT: Final = 0x80000000
"""V4L2_CTRL_FLAG_NEXT_CTRL: asks for the control after this one."""
_INTEGER, _BOOLEAN, _MENU, _INTEGER_MENU = 1, 2, 3, 9
_SETTABLE: Final = frozenset({_INTEGER, _BOOLEAN, _MENU, _INTEGER_MENU})
_DISABLED: Final = 0x1
_READ_ONLY: Final = 0x4
_MOST: Final = 200


@dataclass(frozen=True, slots=True)
class CameraControl:
    """A control that can be set, to a whole number from `least` to `most` or one of `choices`."""

    number: int
    name: str
    kind: int
    least: int
    most: int
    choices: dict[int, str]

    def allows(self, value: float) -> bool:
        return value in self.choices if self.choices else self.least <= value <= self.most

    @property
    def range(self) -> str:
        """What it can be set to, for people."""
        if self.choices:
            return ", ".join(f"{value}: {name}" for value, name in self.choices.items())
        return f"{self.least} to {self.most}"


def set_controls(
    camera: int | str, wanted: Mapping[str, float], *, ioctl: Ioctl | None = None
) -> None:
    """Set these controls; raises `SourceError` for a name or value that the camera does not have.

    Modes such as auto_exposure are set first: they lock and unlock the values that belong to them.
    """
    if not wanted:
        return
    with opened(camera, ioctl) as call:
        there = {one.name: one for one in _controls(call)}
        for name, value in wanted.items():
            if name not in there:
                names = ", ".join(there) or "–"
                raise SourceError(
                    Sentence("camera.no_control", {"camera": camera, "name": name, "there": names})
                )
            if value != int(value) or not there[name].allows(value):
                raise SourceError(
                    Sentence(
                        "camera.control_range",
                        {
                            "camera": camera,
                            "name": name,
                            "value": f"{value:.10g}",
                            "range": there[name].range,
                        },
                    )
                )
        for name in sorted(wanted, key=lambda name: there[name].kind == _INTEGER):
            try:
                call(S_CTRL, bytearray(CONTROL.pack(there[name].number, int(wanted[name]))))
            except OSError as error:
                why = reason_of(error)
                raise SourceError(
                    Sentence("camera.control_locked", {"camera": camera, "name": name, "why": why})
                ) from error


def list_controls(camera: int | str, *, ioctl: Ioctl | None = None) -> list[str]:
    """Return a line for each control: its present value, as configured, and its range."""
    lines = []
    with contextlib.suppress(OSError, SourceError), opened(camera, ioctl) as call:
        for one in _controls(call):
            asked = bytearray(CONTROL.pack(one.number, 0))
            with contextlib.suppress(OSError):
                call(G_CTRL, asked)
                lines.append(f"{one.name} = {CONTROL.unpack(asked)[1]}   # {one.range}")
    return lines


@contextlib.contextmanager
def opened(camera: int | str, ioctl: Ioctl | None) -> Iterator[Callable[[int, bytearray], object]]:
    """Yield V4L2's call on a descriptor of this camera; raises `SourceError` if it has none."""
    node = f"/dev/video{camera}" if isinstance(camera, int) else camera
    try:
        call = ioctl or importlib.import_module("fcntl").ioctl  # not on every system
        descriptor = os.open(node, os.O_RDWR | os.O_NONBLOCK)
    except (ImportError, OSError) as error:
        raise SourceError(Sentence("camera.no_controls", {"camera": camera})) from error
    try:
        yield lambda request, asked: call(descriptor, request, asked)
    finally:
        os.close(descriptor)


def _controls(call: Callable[[int, bytearray], object]) -> Iterator[CameraControl]:
    """Yield the controls that can be set, in the camera's order."""
    number = 0
    for _ in range(_MOST):
        asked = bytearray(QUERY.pack(number | NEXT, 0, b"", 0, 0, 0, 0, 0))
        try:
            call(QUERYCTRL, asked)
        except OSError:
            return  # no more controls, or none at all
        number, kind, name, least, most, _step, _default, flags = QUERY.unpack(asked)
        if kind in _SETTABLE and not flags & (_DISABLED | _READ_ONLY):
            is_menu = kind in (_MENU, _INTEGER_MENU)
            choices = _choices(call, number, kind, range(least, most + 1)) if is_menu else {}
            yield CameraControl(number, _key(name), kind, least, most, choices)


def _choices(
    call: Callable[[int, bytearray], object], number: int, kind: int, places: range
) -> dict[int, str]:
    found = {}
    for place in places[:_MOST]:
        asked = bytearray(MENU.pack(number, place, b""))
        with contextlib.suppress(OSError):  # a menu may have gaps
            call(QUERYMENU, asked)
            text = MENU.unpack(asked)[2]
            is_number = kind == _INTEGER_MENU
            found[place] = str(int.from_bytes(text[:8], "little")) if is_number else _text(text)
    return found


def _text(name: bytes) -> str:
    return name.partition(b"\0")[0].decode("utf-8", "replace")


def _key(name: bytes) -> str:
    """Return a name as v4l2-ctl writes it: "Focus, Absolute" is focus_absolute."""
    return re.sub(r"[^a-z0-9]+", "_", _text(name).lower()).strip("_")
