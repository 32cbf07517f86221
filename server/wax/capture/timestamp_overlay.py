"""Draws the wall clock on the picture: two screens side by side show their drift (thesis 4.2)."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Final

import cv2
import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from wax.capture.source import Picture
    from wax.clock import Clock

_FONT: Final = cv2.FONT_HERSHEY_SIMPLEX
_WHITE: Final = 235
_BLACK: Final = 16
_WIDTH_FRACTION: Final = 0.9
"""Wide enough to be readable after the picture is scaled down by four."""
_HEIGHT_FRACTION: Final = 0.15
"""What it may cover of a picture that is much wider than high."""


class TimestampOverlay:
    """Draws the capture time on each picture, between a source and its slot."""

    def __init__(self, clock: Clock, put: Callable[[Picture], None]) -> None:
        self._clock = clock
        self._put = put

    def __call__(self, picture: Picture) -> None:
        """Draw the time on a picture and pass it on, in the source's thread."""
        age_ms = (self._clock.now_s() - picture.captured_s) * 1000
        self._put(overlay_time(picture, self._clock.wall_ms() - round(age_ms)))


def wall_text(wall_ms: int) -> str:
    """Return the date and the time of day in UTC with milliseconds, for people."""
    moment = datetime.fromtimestamp(wall_ms // 1000, tz=UTC)
    return f"{moment:%Y-%m-%d %H:%M:%S}.{wall_ms % 1000:03d}Z"


def overlay_time(picture: Picture, wall_ms: int) -> Picture:
    """Return a copy of the picture with the wall clock along its lower edge.

    `wall_ms` is the Unix time of its capture.
    """
    i420 = picture.i420.copy()
    luma = i420[: picture.height]
    draw_text(luma, wall_text(wall_ms), bottom=picture.height - max(2, picture.height // 40))
    return replace(picture, i420=i420)


def draw_text(luma: NDArray[np.uint8], text: str, *, bottom: int) -> None:
    """Write white letters with a dark outline, centred and 9/10 of the width wide, into a plane.

    In a picture that is much wider than high they are narrower, and 15 % as high as it.
    """
    # Drawn at one size and then scaled: OpenCV 4 and 5 disagree on the width of a scaled text.
    (text_width, text_height), below = cv2.getTextSize(text, _FONT, 1.0, 2)
    letters = np.zeros((text_height + below, text_width), np.uint8)
    cv2.putText(letters, text, (0, text_height), _FONT, 1.0, 255, 2, cv2.LINE_AA)
    scale = min(
        _WIDTH_FRACTION * luma.shape[1] / text_width,
        _HEIGHT_FRACTION * luma.shape[0] / letters.shape[0],
    )
    width, height = (max(1, round(scale * side)) for side in letters.shape[::-1])
    scaled = cv2.resize(letters, (width, height), interpolation=cv2.INTER_AREA)
    outline = max(1, width // 300)
    scaled = np.pad(scaled, outline)
    dark = cv2.dilate(scaled, np.ones((2 * outline + 1, 2 * outline + 1), np.uint8))
    top = max(0, bottom - scaled.shape[0])
    left = max(0, (luma.shape[1] - scaled.shape[1]) // 2)
    place = luma[top : top + scaled.shape[0], left : left + scaled.shape[1]]
    # By OpenCV: NumPy takes three times as long where it chooses pixel by pixel.
    seen = np.s_[: place.shape[0], : place.shape[1]]
    _, is_dark = cv2.threshold(dark[seen], 64, 255, cv2.THRESH_BINARY)
    cv2.copyTo(np.full_like(place, _BLACK), is_dark, dst=place)
    cv2.max(place, np.minimum(scaled[seen], _WHITE), dst=place)
