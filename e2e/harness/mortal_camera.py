"""A camera for the tests, an ordinary plug-in: the test card, until somebody pulls its plug."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Final

from wax.capture.testcard import TestCardVideo
from wax.errors import SourceError

if TYPE_CHECKING:
    from wax.capture.source import Picture
    from wax.clock import Clock
    from wax.config.settings import VideoSettings

SOURCE: Final = f"{__name__}:MortalCamera"
PULLED: Final = "The plug is out."


def plug(state_home: Path) -> Path:
    """Return the file that stands for the plug: as long as it exists, no picture comes."""
    return state_home / "pulled"


class MortalCamera:
    """Fails as a camera on USB does, and comes back when it is plugged in again."""

    def __init__(self, settings: VideoSettings, clock: Clock) -> None:
        self._card = TestCardVideo(settings, clock)
        self._plug = plug(Path(os.environ["XDG_STATE_HOME"]))

    def open(self) -> None:
        self._check()
        self._card.open()

    def read(self) -> Picture:
        self._check()
        return self._card.read()

    def close(self) -> None:
        self._card.close()

    def _check(self) -> None:
        if self._plug.exists():
            raise SourceError(PULLED)
