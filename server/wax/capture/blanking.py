"""Replaces the picture with black and the sound with silence while the host wants privacy.

This happens before anything is encoded, so that neither a viewer's page nor a tape nor an encoder's
memory holds what was in front of the camera.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.capture.source import Picture, Sound

_BLACK: Final = 16
_GREY: Final = 128
"""Black in limited range: its luma, and its chroma (ITU-R BT.601)."""


class Blanking:
    """Call `picture` and `sound` in the sources' threads."""

    def __init__(self, is_on: Callable[[], bool]) -> None:
        self._is_on = is_on

    def picture(self, picture: Picture) -> Picture:
        """Return the picture, or a black one of its size and time."""
        if not self._is_on():
            return picture
        black = np.full_like(picture.i420, _GREY)
        black[: picture.height] = _BLACK
        return replace(picture, i420=black)

    def sound(self, sound: Sound) -> Sound:
        """Return the sound, or silence of the same length and shape."""
        if not self._is_on():
            return sound
        return replace(sound, samples=np.zeros_like(sound.samples))
