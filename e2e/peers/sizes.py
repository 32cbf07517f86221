"""The sizes at which systems are compared: what each is given, and what it may spend on it."""

from __future__ import annotations

from typing import Final, Literal, NamedTuple

FPS: Final = 30

SizeName = Literal["640x480", "1280x720"]


class Size(NamedTuple):
    width: int
    height: int
    bitrate_bps: int
    """The most that each system is allowed for its largest picture."""

    @property
    def window(self) -> tuple[int, int]:
        """A browser's window in which every page has room for the whole picture."""
        return (self.width + 640, self.height + 240)


SIZES: Final[dict[SizeName, Size]] = {
    "640x480": Size(640, 480, 1_000_000),
    "1280x720": Size(1280, 720, 2_500_000),
}
VGA: Final = SIZES["640x480"]
