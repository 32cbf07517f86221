"""The pictures by which systems are compared: what each is given, and may spend on it."""

from __future__ import annotations

from typing import Final, Literal, NamedTuple

from e2e.peers.film import FilmCard
from wax.capture.testcard import TestCardVideo
from wax.clock import SystemClock
from wax.config.video import VideoSettings

FPS: Final = 30

SizeName = Literal["640x480", "1280x720", "1280x720-film"]


class Size(NamedTuple):
    width: int
    height: int
    bitrate_bps: int
    """The most that each system is allowed for its largest picture."""
    label: str = ""
    """What a row says of it, unless it is the usual one."""
    card: type[TestCardVideo] = TestCardVideo

    @property
    def source(self) -> str:
        """The card as WAX's configuration names it."""
        kind = self.card
        return "testcard" if kind is TestCardVideo else f"{kind.__module__}:{kind.__name__}"

    def camera(self) -> TestCardVideo:
        settings = VideoSettings(source=self.source, width=self.width, height=self.height, fps=FPS)
        return self.card(settings, SystemClock())

    @property
    def window(self) -> tuple[int, int]:
        """A browser's window in which every page has room for the whole picture."""
        return (self.width + 640, self.height + 240)


SIZES: Final[dict[SizeName, Size]] = {
    "640x480": Size(640, 480, 1_000_000),
    "1280x720": Size(1280, 720, 2_500_000, " at 1280×720"),
    "1280x720-film": Size(1280, 720, 2_500_000, ", the film at 1280×720", FilmCard),
}
VGA: Final = SIZES["640x480"]
