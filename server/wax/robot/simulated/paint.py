"""The textures of the flat (pure): small painted pictures, with all colours in BGR.

Patterns are coarse and soft on purpose: fine ones flicker at a distance and cost the encoder bits.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import cv2
import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

Colour = tuple[int, int, int]

_WALLS: Final[dict[str, Colour]] = {
    "cream": (172, 214, 240),
    "mint": (188, 222, 190),
    "white": (222, 228, 230),
    "sky": (232, 204, 164),
    "lilac": (222, 188, 206),
    "tiles": (226, 220, 196),
}
_MATERIALS: Final[dict[str, Colour]] = {
    "sofa": (72, 120, 196),
    "oak": (92, 142, 188),
    "pine": (128, 182, 220),
    "walnut": (52, 76, 112),
    "sideboard": (62, 96, 138),
    "leg": (60, 74, 92),
    "red": (60, 60, 206),
    "blue": (196, 110, 52),
    "granite": (96, 92, 88),
    "cupboard": (226, 232, 236),
    "fridge": (206, 206, 202),
    "stove": (190, 192, 194),
    "bed": (190, 150, 96),
    "pillow": (240, 240, 244),
    "wardrobe": (116, 160, 198),
    "screen": (48, 44, 40),
    "bathtub": (240, 240, 238),
    "washstand": (236, 232, 226),
    "stool": (70, 104, 150),
    "radio": (46, 66, 172),
    "books": (64, 92, 132),
    "pot": (58, 92, 170),
    "leaves": (60, 140, 66),
    "lintel": (214, 222, 226),
    "yellow door": (70, 190, 236),
    "green door": (96, 160, 76),
    "blue door": (190, 126, 58),
    "violet door": (168, 92, 140),
    "white door": (232, 232, 230),
    "red pillar": (52, 52, 208),
    "blue pillar": (204, 108, 40),
    "green pillar": (72, 164, 60),
    "violet jumper": (150, 84, 128),
    "white jumper": (220, 226, 230),
    "face": (150, 184, 222),
}
TRIM: Final[Colour] = (66, 94, 128)
"""The frame round every doorway."""

SIDE_PX = 96
LEAVES_PX = 2 * SIDE_PX
TOP_LIGHT: Final = 1.08


def colour(material: str) -> Colour:
    """Return the plain colour of a material, for its top."""
    return _MATERIALS[material]


def plain(width: int, height: int, fill: Colour) -> NDArray[np.uint8]:
    """Make an image of one colour."""
    return np.full((height, width, 3), fill, np.uint8)


def wall(finish: str, width: int, height: int, px_per_m: float) -> NDArray[np.uint8]:
    """Paint a piece of wall, ceiling on top, with its skirting board."""
    base = _WALLS[finish]
    image = plain(width, height, base)
    skirting = int(0.09 * px_per_m)
    if finish == "tiles":
        lower = int(1.5 * px_per_m)
        image[-lower:] = (214, 196, 150)
        _grid(image[-lower:], int(0.3 * px_per_m), (236, 232, 222))
    elif finish != "white":
        stripe, step = int(0.2 * px_per_m), int(0.4 * px_per_m)
        for x in range(0, width, step):
            image[:, x : x + stripe] = _shade(base, 0.965)
        image[: int(0.06 * px_per_m)] = (240, 244, 246)
    image[-skirting:] = (104, 126, 150) if finish != "tiles" else (150, 140, 118)
    light = np.linspace(0.93, 1.0, height)[:, None, None] * np.ones((1, 1, 1))
    light[height // 2 :] = np.linspace(1.0, 0.9, height - height // 2)[:, None, None]
    return (image * light).astype(np.uint8)


def floor(finish: str, width: int, height: int, px_per_m: float) -> NDArray[np.uint8]:
    """Paint a piece of floor as seen from above."""
    if finish in ("checkers", "small tiles"):
        tile = px_per_m * (0.5 if finish == "checkers" else 0.3)
        light, dark = ((214, 222, 224), (150, 168, 160))
        if finish == "small tiles":
            light, dark = ((222, 218, 206), (206, 196, 172))
        x, y = np.arange(width) // tile, np.arange(height) // tile
        odd = (x[None, :] + y[:, None]) % 2 == 1
        return np.where(odd[..., None], dark, light).astype(np.uint8)
    if finish in ("planks", "dark planks"):
        base = (104, 152, 190) if finish == "planks" else (70, 100, 138)
        return _planks(width, height, px_per_m, base)
    return plain(width, height, {"terracotta": (124, 156, 196), "carpet": (168, 150, 124)}[finish])


def side(material: str) -> NDArray[np.uint8]:
    """Paint the side of a material's box or cylinder, `SIDE_PX` or `LEAVES_PX` square.

    A plant's has a fourth channel, which is 255 where there is a leaf and 0 elsewhere.
    """
    if material == "leaves":
        return _leaves()
    image = plain(SIDE_PX, SIDE_PX, colour(material))
    detail = _DETAILS.get(material) or _DETAILS.get(material.rpartition(" ")[2])
    if detail is not None:
        detail(image, colour(material))
    return image


def top(material: str) -> NDArray[np.uint8]:
    """Paint the top of a material's box: one colour, a little brighter than its sides."""
    return plain(8, 8, _shade(colour(material), TOP_LIGHT))


def _leaves() -> NDArray[np.uint8]:
    n = LEAVES_PX
    image, mask = plain(n, n, colour("leaves")), np.zeros((n, n), np.uint8)
    rng = np.random.default_rng(7)
    foot = np.array([n / 2, n * 0.98])
    for number in range(22):
        angle = np.radians(90 + (number - 10.5) * 7.5 + rng.uniform(-5, 5))
        length = n * rng.uniform(0.5, 0.92) * (1 - abs(number - 10.5) / 40)
        tip = foot + length * np.array([np.cos(angle), -np.sin(angle)])
        middle = tuple(int(v) for v in (foot + tip) / 2)
        tilt = float(np.degrees(np.arctan2(*(tip - foot)[::-1])))
        axes = (int(length / 2), int(n * 0.045))
        green = (int(rng.integers(44, 84)), int(rng.integers(112, 178)), int(rng.integers(48, 92)))
        cv2.ellipse(image, middle, axes, tilt, 0, 360, green, -1, cv2.LINE_AA)
        cv2.ellipse(mask, middle, axes, tilt, 0, 360, 255, -1)
    return np.dstack((image, mask))


def _shade(base: Colour, factor: float) -> Colour:
    blue, green, red = (min(255, int(part * factor)) for part in base)
    return blue, green, red


def _grid(image: NDArray[np.uint8], step: int, line: Colour) -> None:
    image[::step] = line
    image[:, ::step] = line


def _planks(width: int, height: int, px_per_m: float, base: Colour) -> NDArray[np.uint8]:
    image = plain(width, height, base)
    rng = np.random.default_rng(3)
    plank, length = int(0.22 * px_per_m), int(1.6 * px_per_m)
    for row, y in enumerate(range(0, height, plank)):
        for x in range(-(row * 37) % length - length, width, length):
            tone = _shade(base, float(rng.uniform(0.88, 1.1)))
            image[y : y + plank, max(x, 0) : max(x + length, 0)] = tone
        image[y] = _shade(base, 0.72)
    return image


def _door(image: NDArray[np.uint8], base: Colour) -> None:
    for x0, y0, x1, y1 in ((16, 8, 80, 40), (16, 50, 80, 88)):
        cv2.rectangle(image, (x0, y0), (x1, y1), _shade(base, 0.7), 2)
    for x in (10, 86):
        cv2.circle(image, (x, 48), 3, (40, 190, 220), -1, cv2.LINE_AA)


def _stripes(image: NDArray[np.uint8], _: Colour) -> None:
    for y in range(0, SIDE_PX, 24):
        image[y : y + 12] = (236, 238, 240)


def _cushions(image: NDArray[np.uint8], base: Colour) -> None:
    image[:14] = _shade(base, 1.12)
    image[-10:] = _shade(base, 0.6)
    image[14:86, ::32] = _shade(base, 0.7)


def _screen(image: NDArray[np.uint8], _: Colour) -> None:
    cv2.rectangle(image, (6, 8), (90, 84), (150, 96, 40), -1)
    for y in range(16, 80, 10):
        cv2.line(image, (12, y), (30 + (y * 7) % 44, y), (170, 220, 150), 2)


def _books(image: NDArray[np.uint8], _: Colour) -> None:
    rng = np.random.default_rng(5)
    covers = ((60, 70, 190), (70, 160, 90), (180, 120, 60), (60, 180, 220), (150, 80, 140))
    for shelf in range(4):
        x, bottom = 5, shelf * 24 + 22
        while x < 84:
            wide, tall = int(rng.integers(5, 10)), int(rng.integers(13, 19))
            cover = covers[int(rng.integers(len(covers)))]
            cv2.rectangle(image, (x, bottom - tall), (min(x + wide - 1, 89), bottom), cover, -1)
            x += wide
        image[bottom : bottom + 3] = (40, 58, 84)


def _stove(image: NDArray[np.uint8], _: Colour) -> None:
    cv2.rectangle(image, (14, 34), (82, 80), (60, 56, 54), -1)
    for x in range(20, 84, 14):
        cv2.circle(image, (x, 16), 4, (50, 50, 50), -1, cv2.LINE_AA)


def _fridge(image: NDArray[np.uint8], base: Colour) -> None:
    cv2.line(image, (0, 34), (SIDE_PX, 34), _shade(base, 0.7), 2)
    cv2.line(image, (12, 10), (12, 28), (90, 90, 90), 3)
    cv2.line(image, (12, 42), (12, 66), (90, 90, 90), 3)


def _fronts(image: NDArray[np.uint8], base: Colour) -> None:
    wide = SIDE_PX // 3
    for x in range(0, SIDE_PX, wide):
        cv2.rectangle(image, (x + 2, 3), (x + wide - 3, SIDE_PX - 8), _shade(base, 0.7), 1)
        cv2.line(image, (x + 8, 40), (x + 8, 54), (96, 100, 104), 2)
    image[-6:] = _shade(base, 0.5)


def _radio(image: NDArray[np.uint8], _: Colour) -> None:
    cv2.rectangle(image, (4, 6), (91, 90), (36, 50, 132), 2)
    cv2.circle(image, (30, 50), 24, (40, 44, 52), -1, cv2.LINE_AA)
    for radius in (8, 14, 20):
        cv2.circle(image, (30, 50), radius, (110, 116, 124), 2, cv2.LINE_AA)
    cv2.rectangle(image, (60, 22), (88, 44), (150, 226, 246), -1)
    cv2.line(image, (72, 24), (72, 42), (40, 40, 200), 2)
    cv2.circle(image, (74, 66), 9, (196, 204, 210), -1, cv2.LINE_AA)


def _jumper(image: NDArray[np.uint8], base: Colour) -> None:
    image[46:] = (84, 66, 58)
    image[90:] = (40, 40, 44)
    image[46:, 46:50] = (58, 46, 40)
    for x in (18, 76):
        cv2.line(image, (x, 10), (x, 44), _shade(base, 0.75), 2)
    for x in (13, 82):
        cv2.circle(image, (x, 52), 6, colour("face"), -1, cv2.LINE_AA)


def _face(image: NDArray[np.uint8], _: Colour) -> None:
    image[:26] = (40, 56, 78)
    for x in (32, 64):
        cv2.circle(image, (x, 44), 4, (50, 40, 36), -1, cv2.LINE_AA)
    cv2.ellipse(image, (48, 66), (14, 9), 0.0, 10.0, 170.0, (90, 90, 190), 3, cv2.LINE_AA)


_DETAILS: Final[dict[str, Callable[[NDArray[np.uint8], Colour], None]]] = {
    "door": _door,
    "pillar": _stripes,
    "sofa": _cushions,
    "bed": _cushions,
    "screen": _screen,
    "books": _books,
    "stove": _stove,
    "fridge": _fridge,
    "cupboard": _fronts,
    "wardrobe": _fronts,
    "washstand": _fronts,
    "sideboard": _fronts,
    "radio": _radio,
    "jumper": _jumper,
    "face": _face,
}
