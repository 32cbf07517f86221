"""A camera's controls through V4L2's calls (linux/videodev2.h), with a simulated kernel."""

from __future__ import annotations

import errno
from typing import TYPE_CHECKING

import pytest

from wax.capture import list_devices as devices
from wax.capture.v4l2_controls import (
    CONTROL,
    G_CTRL,
    MENU,
    NEXT,
    QUERY,
    QUERYCTRL,
    QUERYMENU,
    S_CTRL,
    list_controls,
    set_controls,
)
from wax.errors import SourceError

if TYPE_CHECKING:
    from pathlib import Path

INTEGER, BOOLEAN, MENU_KIND, CLASS, INTEGER_MENU = 1, 2, 3, 6, 9
READ_ONLY = 0x4


class Webcam:
    """The kernel's answers for a webcam: a call changes the bytes that it is given."""

    def __init__(self) -> None:
        self.there = {
            0x980001: (CLASS, b"User Controls", 0, 0, READ_ONLY),
            0x980900: (INTEGER, b"Brightness", -64, 64, 0),
            0x980918: (INTEGER_MENU, b"Power Line Frequency", 0, 2, 0),
            0x9A0901: (MENU_KIND, b"Auto Exposure", 0, 3, 0),
            0x9A0902: (INTEGER, b"Exposure Time, Absolute", 3, 2047, 0),
            0x9A090C: (BOOLEAN, b"Focus, Automatic Continuous", 0, 1, 0),
            0x9A0920: (INTEGER, b"Privacy", 0, 1, READ_ONLY),
        }
        self.values = {0x980900: 0, 0x980918: 1, 0x9A0901: 3, 0x9A0902: 157, 0x9A090C: 1}
        self.menus = {
            (0x9A0901, 1): b"Manual Mode",
            (0x9A0901, 3): b"Aperture Priority Mode",
            **{(0x980918, place): (50 * place).to_bytes(8, "little") for place in range(3)},
        }

    def ioctl(self, _descriptor: int, request: int, asked: bytearray) -> int:
        if request == QUERYCTRL:
            after = int.from_bytes(asked[:4], "little") & ~NEXT
            number = next((one for one in self.there if one > after), None)
            if number is None:
                raise OSError(errno.EINVAL, "Invalid argument")
            kind, name, least, most, flags = self.there[number]
            asked[:] = QUERY.pack(number, kind, name, least, most, 1, least, flags)
        elif request == QUERYMENU:
            number, place, _ = MENU.unpack(asked)
            if (number, place) not in self.menus:
                raise OSError(errno.EINVAL, "Invalid argument")
            asked[:] = MENU.pack(number, place, self.menus[number, place])
        elif request == G_CTRL:
            number, _ = CONTROL.unpack(asked)
            asked[:] = CONTROL.pack(number, self.values[number])
        else:
            assert request == S_CTRL
            number, value = CONTROL.unpack(asked)
            if number == 0x9A0902 and self.values[0x9A0901] != 1:
                raise OSError(errno.EACCES, "Permission denied")
            self.values[number] = value
        return 0


@pytest.fixture
def node(tmp_path: Path) -> str:
    (tmp_path / "video0").write_bytes(b"")
    return str(tmp_path / "video0")


def test_the_structures_are_the_kernels() -> None:
    """The request codes contain the sizes of their structures (_IOWR)."""
    for call, form in ((G_CTRL, CONTROL), (S_CTRL, CONTROL), (QUERYCTRL, QUERY), (QUERYMENU, MENU)):
        assert call >> 16 & 0x3FFF == form.size


def test_each_control_is_listed_as_it_is_written(node: str) -> None:
    """A line has the name, the present value and the range; fixed controls are left out."""
    assert list_controls(node, ioctl=Webcam().ioctl) == [
        "brightness = 0   # -64 to 64",
        "power_line_frequency = 1   # 0: 0, 1: 50, 2: 100",
        "auto_exposure = 3   # 1: Manual Mode, 3: Aperture Priority Mode",
        "exposure_time_absolute = 157   # 3 to 2047",
        "focus_automatic_continuous = 1   # 0 to 1",
    ]


def test_a_mode_is_set_before_what_it_unlocks(node: str) -> None:
    """Whatever their order in the file, manual exposure is set before the exposure."""
    webcam = Webcam()
    wanted = {
        "exposure_time_absolute": 100,
        "auto_exposure": 1,
        "focus_automatic_continuous": False,
    }
    set_controls(node, wanted, ioctl=webcam.ioctl)
    assert webcam.values == {
        0x980900: 0,
        0x980918: 1,
        0x9A0901: 1,
        0x9A0902: 100,
        0x9A090C: 0,
    }


@pytest.mark.parametrize(
    ("wanted", "says"),
    [
        ({"exposure": 9}, r"no control exposure; it has: brightness, power_line_frequency, auto_"),
        ({"privacy": 1}, "no control privacy"),
        ({"exposure_time_absolute": 2}, r"exposure_time_absolute cannot be 2; it can be 3 to 2047"),
        ({"brightness": 0.5}, r"brightness cannot be 0\.5"),
        ({"auto_exposure": 2}, r"cannot be 2; it can be 1: Manual Mode, 3: Aperture Priority Mode"),
    ],
)
def test_what_cannot_be_set_is_a_sentence(wanted: dict[str, float], says: str, node: str) -> None:
    """A wrong name or value is a sentence with the right ones, and nothing is set."""
    webcam = Webcam()
    with pytest.raises(SourceError, match=says):
        set_controls(node, wanted | {"focus_automatic_continuous": 0}, ioctl=webcam.ioctl)
    assert webcam.values == Webcam().values


def test_what_is_locked_says_what_may_be_missing(node: str) -> None:
    """The sentence for a refused value gives the reason and the mode that may be missing."""
    with pytest.raises(
        SourceError, match=r"be set \(Permission denied\); some need .*auto_exposure"
    ):
        set_controls(node, {"exposure_time_absolute": 9}, ioctl=Webcam().ioctl)


def test_a_device_without_v4l2_is_a_sentence(node: str) -> None:
    """A file has no controls, and the error for a missing device says so."""
    with pytest.raises(SourceError, match="no control brightness; it has: –"):
        set_controls(node, {"brightness": 1})
    with pytest.raises(SourceError, match="cannot be set, which takes V4L2"):
        set_controls(f"{node}1", {"brightness": 1})
    assert list_controls(node) == list_controls(f"{node}1") == []
    set_controls(f"{node}1", {})


def test_devices_tells_them_below_their_camera(monkeypatch: pytest.MonkeyPatch) -> None:
    """`wax devices` lists a camera's controls below it."""
    webcam = devices.ListedDevice("[video] source", "/dev/video7", "HD Webcam")
    monkeypatch.setattr(devices, "list_cameras", lambda: [webcam])
    monkeypatch.setattr(devices, "list_controls", lambda _: ["brightness = 0   # -64 to 64"])
    _, camera, heading, control, *_ = devices.list_devices()
    assert camera == '  [video] source = "/dev/video7"   # HD Webcam'
    assert "[video.controls]" in heading
    assert control == "      brightness = 0   # -64 to 64"
