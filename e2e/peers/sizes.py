"""The sizes at which systems are compared: what each is given, and what it may spend on it."""

from __future__ import annotations

from typing import Final, Literal, NamedTuple

FPS: Final = 30

SizeName = Literal["640x480"]


class Size(NamedTuple):
    width: int
    height: int
    bitrate_bps: int
    """The most that each system is allowed for its largest picture."""


SIZES: Final[dict[SizeName, Size]] = {
    "640x480": Size(640, 480, 1_000_000),
}
VGA: Final = SIZES["640x480"]
