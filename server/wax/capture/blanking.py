"""Replaces the picture with black and the sound with silence while the host wants privacy.

This happens before anything is encoded, so that neither a viewer's page nor a tape nor an encoder's
memory holds what was in front of the camera.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from wax.capture.letterbox import black

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.capture.source import Picture, Sound

_SPACING_S: Final = 0.095
"""Of 30 pictures a second ten stay: black costs as much to encode, and no browser counts a gap of
0.1 s as a freeze."""


class Blanking:
    """Blanks one camera and one microphone: call `picture` and `sound` in their threads."""

    def __init__(self, is_on: Callable[[], bool]) -> None:
        self._is_on = is_on
        self._last: Picture | None = None

    def picture(self, picture: Picture) -> Picture | None:
        """Return the picture, or a black one of its size and time; None between two of these."""
        if not self._is_on():
            self._last = None
            return picture
        last = self._last
        if last is None or last.i420.shape != picture.i420.shape:
            i420 = black(picture.width, picture.height)
        elif 0.0 <= picture.captured_s - last.captured_s < _SPACING_S:
            return None
        else:
            i420 = last.i420
        self._last = replace(picture, i420=i420)
        return self._last

    def sound(self, sound: Sound) -> Sound:
        """Return the sound, or silence of the same length and shape."""
        if not self._is_on():
            return sound
        return replace(sound, samples=np.zeros_like(sound.samples))
