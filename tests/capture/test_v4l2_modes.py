"""A camera's modes through V4L2's calls (linux/videodev2.h), with a simulated kernel."""

from __future__ import annotations

import errno
from typing import TYPE_CHECKING

import pytest

from wax.capture.v4l2_modes import (
    DISCRETE,
    ENUM_FMT,
    ENUM_FRAMEINTERVALS,
    ENUM_FRAMESIZES,
    FORMAT,
    INTERVAL,
    SIZE,
    Mode,
    list_modes,
)

if TYPE_CHECKING:
    from pathlib import Path

STEPWISE = 3
END = OSError(errno.EINVAL, "Invalid argument")


def _fourcc(name: bytes) -> int:
    return int.from_bytes(name, "little")


class Kernel:
    """Its answers for cameras whose formats have these sizes, each with its rates."""

    def __init__(self, formats: dict[bytes, dict[tuple[int, ...], list[int]]]) -> None:
        self.formats = formats

    def ioctl(self, _descriptor: int, request: int, asked: bytearray) -> int:
        index = int.from_bytes(asked[:4], "little")
        sizes = self.formats.get(bytes(asked[4:8]), {})
        try:
            if request == ENUM_FMT:
                name = list(self.formats)[index]
                asked[:] = FORMAT.pack(index, 1, 0, b"a format", _fourcc(name), 0)
            elif request == ENUM_FRAMESIZES:
                size = list(sizes)[index]
                kind, rest = (DISCRETE, [0] * 4) if len(size) == 2 else (STEPWISE, [])
                asked[:] = SIZE.pack(index, _fourcc(bytes(asked[4:8])), kind, *size, *rest)
            else:
                assert request == ENUM_FRAMEINTERVALS
                _, pixels, width, height, *_ = INTERVAL.unpack(asked)
                rates = sizes.get((width, height)) or next(iter(sizes.values()))
                asked[:] = INTERVAL.pack(
                    index, pixels, width, height, DISCRETE, 1, rates[index], *[0] * 4
                )
        except IndexError:
            raise END from None
        return 0


@pytest.fixture
def node(tmp_path: Path) -> str:
    (tmp_path / "video0").write_bytes(b"")
    return str(tmp_path / "video0")


def test_each_size_has_the_best_rate_of_its_formats(node: str) -> None:
    """A size counts with its highest rate, but not in a format that OpenCV cannot decode."""
    kernel = Kernel(
        {
            b"YUYV": {(640, 480): [30, 15], (1280, 720): [10, 5]},
            b"MJPG": {(1280, 720): [30], (1920, 1080): [30]},
            b"H264": {(3840, 2160): [30]},
        }
    )
    assert set(list_modes(node, ioctl=kernel.ioctl)) == {
        Mode(640, 480, 30.0),
        Mode(1280, 720, 30.0),
        Mode(1920, 1080, 30.0),
    }


def test_of_a_range_the_usual_sizes_are_listed(node: str) -> None:
    """A driver that names a range of sizes has the largest, and those that WAX would choose."""
    kernel = Kernel({b"YUYV": {(32, 2592, 2, 32, 1944, 2): [25]}})
    assert {one[:2] for one in list_modes(node, ioctl=kernel.ioctl)} == {
        (2592, 1944),
        (1280, 720),
        (640, 480),
    }


def test_a_camera_that_is_not_there_has_none(tmp_path: Path) -> None:
    """No camera, or a file that is none, has no modes and is no error."""
    assert list_modes(str(tmp_path / "none")) == []
    (tmp_path / "file").write_bytes(b"")
    assert list_modes(str(tmp_path / "file")) == []
