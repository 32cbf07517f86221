"""A head whose mouth can be read by a machine.

The mouth is the only red thing in the picture: within it R > 180, G < 90, B < 90 also after VP8.
It is an ellipse about the vertical middle line, between 0.55 and 0.85 of the height; the rows of
red in the middle columns, by a quarter of the height, are its opening, 0…1.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import cv2
import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

WIDTH: Final = 640
HEIGHT: Final = 480
FULL_OPENING_ROWS: Final = HEIGHT // 4

_Colour = tuple[int, int, int]
"""Blue, green, red, as OpenCV has it; none but the mouth has little green and much red."""

_WALL: Final = (222, 205, 178)
_HAIR: Final = (44, 66, 94)
_SKIN: Final = (172, 205, 240)
_LIP: Final = (104, 118, 176)
_RED: Final = (0, 0, 255)
_WHITE: Final = (250, 250, 250)
_DARK: Final = (40, 36, 34)

_MIDDLE: Final = WIDTH / 2
_MOUTH_TOP: Final = 0.64 * HEIGHT
_MOUTH_HALF_WIDTH: Final = 66.0
_RISE: Final = 0.2
"""Share of the opening by which the upper lip goes up; the jaw does the rest."""
_CLOSED: Final = 0.03
"""Below it the lips are a line."""
_SPREAD: Final = 0.9
"""By so many rows OpenCV's smooth edge makes an ellipse too high, above and below."""
_SHIFT: Final = 4
"""Binary places that OpenCV keeps, so that the lips move by less than a row."""


def draw(opening: float) -> NDArray[np.uint8]:
    """Return the picture with the mouth so far open, blue, green, red, of `HEIGHT` × `WIDTH`."""
    picture = np.full((HEIGHT, WIDTH, 3), _WALL, np.uint8)
    jaw = 26 * opening
    _ellipse(picture, (_MIDDLE, 196), (172, 188), _HAIR)
    _ellipse(picture, (_MIDDLE, 206), (140, 160), _SKIN)
    _ellipse(picture, (_MIDDLE, 300 + jaw / 2), (118, 122 + jaw / 2), _SKIN)
    for x in (_MIDDLE - 62, _MIDDLE + 62):
        _ellipse(picture, (x, 200), (27, 19), _WHITE)
        _ellipse(picture, (x, 200), (12, 12), _DARK)
    if opening < _CLOSED:
        _ellipse(picture, (_MIDDLE, _MOUTH_TOP), (_MOUTH_HALF_WIDTH, 4), _LIP)
        return picture
    high = opening * FULL_OPENING_ROWS
    middle = (_MIDDLE, _MOUTH_TOP + high * (0.5 - _RISE))
    wide = _MOUTH_HALF_WIDTH - 12 * opening
    _ellipse(picture, middle, (wide + 7, high / 2 + 7), _LIP)
    _ellipse(picture, middle, (wide, high / 2 - _SPREAD), _RED)
    return picture


def _ellipse(
    picture: NDArray[np.uint8],
    middle: tuple[float, float],
    half: tuple[float, float],
    colour: _Colour,
) -> None:
    """Fill one; `middle` in pixel edges, as the rows and columns are counted."""
    x, y, wide, high = (round(one * 2**_SHIFT) for one in (middle[0] - 0.5, middle[1] - 0.5, *half))
    cv2.ellipse(picture, (x, y), (wide, high), 0, 0, 360, colour, -1, cv2.LINE_AA, _SHIFT)
