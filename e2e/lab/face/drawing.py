"""A friendly face whose mouth can be read by a machine.

The mouth is the only red thing in the picture: within it R > 180, G < 90, B < 90 also after VP8.
It is an ellipse about the vertical middle line, between 0.55 and 0.85 of the height; the rows of
red in the middle columns, by a quarter of the height, are its opening, 0…1.
"""

from __future__ import annotations

from dataclasses import dataclass
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
_WALL_LIGHT: Final = (236, 224, 204)
_HAIR: Final = (44, 66, 94)
_HAIR_LIGHT: Final = (64, 92, 128)
_SKIN: Final = (172, 205, 240)
_SKIN_SHADE: Final = (142, 176, 218)
_CHEEK: Final = (150, 172, 238)
_LIP: Final = (104, 118, 176)
_RED: Final = (0, 0, 255)
_WHITE: Final = (250, 250, 250)
_IRIS: Final = (130, 104, 56)
_DARK: Final = (40, 36, 34)
_SHIRT: Final = (124, 112, 40)
_SHIRT_DARK: Final = (98, 88, 30)

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


@dataclass(frozen=True, slots=True)
class Look:
    """What moves in the face, each 0…1; at rest the mouth and nothing else is 0."""

    mouth: float = 0.0
    lids: float = 0.0
    """How far the eyes are shut."""
    brows: float = 0.0
    """How far they are raised."""


def draw(look: Look) -> NDArray[np.uint8]:
    """Return the picture, blue, green, red, of `HEIGHT` × `WIDTH`."""
    picture = _BACKGROUND.copy()
    jaw = 26 * look.mouth
    _head(picture, jaw)
    for side in (-1, 1):
        _eye(picture, _MIDDLE + side * 62, look)
    _nose(picture)
    _mouth(picture, look.mouth)
    return picture


def _wall() -> NDArray[np.uint8]:
    """Draw what never moves: the wall, the hair behind the head, neck and shirt."""
    picture = np.full((HEIGHT, WIDTH, 3), _WALL, np.uint8)
    _ellipse(picture, (_MIDDLE, 210), (300, 250), _WALL_LIGHT)
    _ellipse(picture, (_MIDDLE, 196), (172, 188), _HAIR)
    for side in (-1, 1):
        _ellipse(picture, (_MIDDLE + side * 138, 290), (44, 110), _HAIR)
    _ellipse(picture, (_MIDDLE, 560), (280, 128), _SHIRT)
    _ellipse(picture, (_MIDDLE, 452), (84, 36), _SHIRT_DARK)
    cv2.rectangle(picture, (264, 380), (376, 450), _SKIN_SHADE, -1)
    _ellipse(picture, (_MIDDLE, 448), (56, 26), _SKIN_SHADE)
    return picture


def _head(picture: NDArray[np.uint8], jaw: float) -> None:
    for side in (-1, 1):
        _ellipse(picture, (_MIDDLE + side * 141, 222), (22, 34), _SKIN_SHADE)
    _ellipse(picture, (_MIDDLE, 206), (140, 160), _SKIN)
    _ellipse(picture, (_MIDDLE, 300 + jaw / 2), (118, 122 + jaw / 2), _SKIN)
    for side in (-1, 1):
        _ellipse(picture, (_MIDDLE + side * 92, 262), (26, 18), _CHEEK)
    hairline = [(446, 142), (404, 104), (352, 112), (300, 132), (236, 128), (196, 146)]
    outside = [(176, 190), (184, 96), (250, 46), (330, 34), (412, 58), (456, 110), (464, 190)]
    fringe = np.array([*outside, *hairline])
    cv2.fillPoly(picture, [fringe], _HAIR, cv2.LINE_AA)
    for left in (232, 282, 334):
        strand = np.array([(left + 34, 50), (left + 8, 76), (left, 108)])
        cv2.polylines(picture, [strand], False, _HAIR_LIGHT, 3, cv2.LINE_AA)


def _eye(picture: NDArray[np.uint8], x: float, look: Look) -> None:
    y, open_high = 200.0, 19 * (1 - look.lids)
    if open_high > 3:
        _ellipse(picture, (x, y), (27, open_high), _WHITE)
        seen = min(open_high - 1, 14.0)
        _ellipse(picture, (x, y), (14, seen), _IRIS)
        _ellipse(picture, (x, y), (7, min(seen, 7.0)), _DARK)
        if open_high > 9:
            _ellipse(picture, (x + 5, y - 5), (3.5, 3.5), _WHITE)
        _arc(picture, (x, y), (28, open_high + 1), (190, 350), _DARK, thick=4)
    else:
        _arc(picture, (x, y - 4), (28, 10), (15, 165), _DARK, thick=4)
    _arc(picture, (x, 174 - 9 * look.brows), (32, 12), (200, 340), _HAIR, thick=7)


def _nose(picture: NDArray[np.uint8]) -> None:
    _arc(picture, (_MIDDLE, 250), (20, 15), (25, 155), _SKIN_SHADE, thick=6)


def _mouth(picture: NDArray[np.uint8], opening: float) -> None:
    if opening < _CLOSED:
        _arc(picture, (_MIDDLE, _MOUTH_TOP - 14), (_MOUTH_HALF_WIDTH, 18), (20, 160), _LIP, thick=6)
        return
    high = opening * FULL_OPENING_ROWS
    middle = (_MIDDLE, _MOUTH_TOP + high * (0.5 - _RISE))
    wide = _MOUTH_HALF_WIDTH - 12 * opening
    _ellipse(picture, middle, (wide + 7, high / 2 + 7), _LIP)
    _ellipse(picture, middle, (wide, high / 2 - _SPREAD), _RED)


def _ellipse(
    picture: NDArray[np.uint8],
    middle: tuple[float, float],
    half: tuple[float, float],
    colour: _Colour,
) -> None:
    """Fill one; `middle` in pixel edges, as the rows and columns are counted."""
    cv2.ellipse(
        picture, _fixed(middle, -0.5), _fixed(half), 0, 0, 360, colour, -1, cv2.LINE_AA, _SHIFT
    )


def _arc(
    picture: NDArray[np.uint8],
    middle: tuple[float, float],
    half: tuple[float, float],
    degrees: tuple[int, int],
    colour: _Colour,
    *,
    thick: int,
) -> None:
    """Draw a piece of one; degrees count clockwise from three o'clock."""
    cv2.ellipse(
        picture, _fixed(middle, -0.5), _fixed(half), 0, *degrees, colour, thick, cv2.LINE_AA, _SHIFT
    )


def _fixed(point: tuple[float, float], offset: float = 0.0) -> tuple[int, int]:
    return (round((point[0] + offset) * 2**_SHIFT), round((point[1] + offset) * 2**_SHIFT))


_BACKGROUND: Final = _wall()
