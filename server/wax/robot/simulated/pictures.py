"""What hangs on the walls and lies on the floors of the flat (pure)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np

from wax.robot.simulated.paint import plain

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray


def picture(name: str, width: int, height: int) -> NDArray[np.uint8]:
    """Paint the picture `name`; a name in capitals is a sign with these words."""
    if name.isupper():
        return _sign(name, width, height)
    image = plain(200, 200, (240, 240, 240))
    _PICTURES[name](image)
    return np.asarray(cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA), np.uint8)


def rug(name: str, width: int, height: int, under: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Paint a rug over the floor `under` of the same size."""
    image = plain(width, height, (0, 0, 0))
    if name == "round rug":
        image[:] = under
        middle = (width // 2, height // 2)
        for share, tone in ((1.0, (120, 90, 190)), (0.75, (190, 170, 236)), (0.45, (120, 90, 190))):
            axes = (int(width / 2 * share) - 1, int(height / 2 * share) - 1)
            cv2.ellipse(image, middle, axes, 0, 0, 360, tone, -1)
        return image
    outer, inner, core = {
        "rug": ((52, 56, 150), (150, 190, 220), (70, 76, 176)),
        "runner": ((70, 60, 120), (140, 150, 190), (86, 74, 150)),
        "bath mat": ((200, 160, 90), (236, 226, 200), (214, 180, 120)),
    }[name]
    edge = max(2, min(width, height) // 12)
    image[:] = outer
    image[edge:-edge, edge:-edge] = inner
    image[2 * edge : -2 * edge, 2 * edge : -2 * edge] = core
    return image


def _sign(words: str, width: int, height: int) -> NDArray[np.uint8]:
    big = plain(width * 4, height * 4, (120, 72, 28))
    cv2.rectangle(big, (4, 4), (width * 4 - 5, height * 4 - 5), (255, 255, 255), 6)
    font = cv2.FONT_HERSHEY_DUPLEX
    (wide, tall), _ = cv2.getTextSize(words, font, 1.0, 2)
    scale = min((width * 4 - 40) / wide, (height * 4 - 24) / tall)
    (wide, tall), _ = cv2.getTextSize(words, font, scale, 6)
    foot = ((width * 4 - wide) // 2, (height * 4 + tall) // 2)
    cv2.putText(big, words, foot, font, scale, (255, 255, 255), 6, cv2.LINE_AA)
    return np.asarray(cv2.resize(big, (width, height), interpolation=cv2.INTER_AREA), np.uint8)


def _frame(image: NDArray[np.uint8], tone: tuple[int, int, int] = (40, 62, 92)) -> None:
    cv2.rectangle(image, (0, 0), (199, 199), tone, 16)


def _sailing_boat(image: NDArray[np.uint8]) -> None:
    image[:130] = (236, 200, 140)
    image[130:] = (170, 104, 36)
    cv2.circle(image, (160, 46), 20, (90, 220, 250), -1)
    cv2.fillPoly(image, [np.array([(95, 30), (95, 124), (40, 124)], np.int32)], (250, 250, 250))
    cv2.fillPoly(image, [np.array([(103, 46), (103, 124), (146, 124)], np.int32)], (60, 60, 220))
    hull = np.array([(40, 134), (160, 134), (136, 160), (62, 160)], np.int32)
    cv2.fillPoly(image, [hull], (40, 60, 100))
    _frame(image)


def _television(image: NDArray[np.uint8]) -> None:
    image[:] = (34, 30, 28)
    cv2.rectangle(image, (12, 14), (187, 176), (150, 110, 60), -1)
    cv2.circle(image, (100, 95), 50, (90, 180, 90), -1)
    cv2.circle(image, (84, 82), 12, (60, 140, 200), -1)


def _window(image: NDArray[np.uint8]) -> None:
    image[:120] = (246, 222, 178)
    image[120:] = (110, 180, 116)
    cv2.ellipse(image, (60, 60), (34, 14), 0, 0, 360, (252, 250, 248), -1)
    cv2.circle(image, (150, 124), 30, (70, 136, 70), -1)
    _frame(image, (244, 246, 248))
    cv2.line(image, (100, 0), (100, 199), (244, 246, 248), 8)
    cv2.line(image, (0, 96), (199, 96), (244, 246, 248), 8)


def _sun_poster(image: NDArray[np.uint8]) -> None:
    image[:] = (60, 110, 236)
    for angle in np.linspace(0, 2 * np.pi, 12, endpoint=False):
        tip = (int(100 + 90 * np.cos(angle)), int(100 + 90 * np.sin(angle)))
        cv2.line(image, (100, 100), tip, (90, 220, 255), 10)
    cv2.circle(image, (100, 100), 50, (80, 230, 255), -1)
    for x in (82, 118):
        cv2.circle(image, (x, 88), 7, (40, 40, 40), -1)
    cv2.ellipse(image, (100, 106), (26, 18), 0, 10, 170, (40, 40, 40), 5)
    _frame(image)


def _shelf(image: NDArray[np.uint8]) -> None:
    image[:] = (188, 222, 190)
    image[100:116] = (80, 120, 160)
    for number, tone in enumerate(((60, 60, 200), (200, 140, 60), (70, 190, 220), (90, 160, 90))):
        x = 14 + number * 46
        cv2.rectangle(image, (x, 44), (x + 32, 99), tone, -1)


def _wall_clock(image: NDArray[np.uint8]) -> None:
    image[:] = (188, 222, 190)
    cv2.circle(image, (100, 100), 96, (50, 50, 180), -1)
    cv2.circle(image, (100, 100), 80, (250, 250, 250), -1)
    cv2.line(image, (100, 100), (100, 44), (30, 30, 30), 9)
    cv2.line(image, (100, 100), (140, 120), (30, 30, 30), 9)


def _fruit(image: NDArray[np.uint8]) -> None:
    image[:] = (200, 236, 250)
    cv2.circle(image, (80, 120), 44, (50, 50, 214), -1)
    cv2.circle(image, (136, 130), 36, (40, 150, 250), -1)
    cv2.line(image, (80, 80), (90, 50), (40, 80, 60), 7)
    cv2.ellipse(image, (112, 56), (24, 10), -20, 0, 360, (80, 170, 80), -1)
    _frame(image)


def _moon(image: NDArray[np.uint8]) -> None:
    image[:] = (96, 52, 30)
    cv2.circle(image, (110, 96), 56, (150, 236, 255), -1)
    cv2.circle(image, (86, 84), 50, (96, 52, 30), -1)
    for x, y in ((40, 40), (160, 44), (44, 150), (150, 164)):
        cv2.circle(image, (x, y), 6, (230, 250, 255), -1)
    _frame(image)


def _map(image: NDArray[np.uint8]) -> None:
    image[:] = (214, 176, 120)
    for x, y, wide, tall in (
        (52, 70, 34, 24),
        (70, 140, 18, 34),
        (130, 70, 46, 30),
        (150, 140, 22, 16),
    ):
        cv2.ellipse(image, (x, y), (wide, tall), 0, 0, 360, (96, 170, 110), -1)
    _frame(image)


def _rocket(image: NDArray[np.uint8]) -> None:
    image[:] = (110, 60, 60)
    cv2.fillPoly(image, [np.array([(60, 150), (140, 150), (100, 190)], np.int32)], (50, 150, 255))
    cv2.ellipse(image, (100, 90), (34, 70), 0, 0, 360, (240, 240, 244), -1)
    cv2.circle(image, (100, 76), 14, (200, 140, 60), -1)
    for x in (60, 140):
        fin = np.array([(x, 160), (100, 120), (x + (100 - x) // 3, 100)], np.int32)
        cv2.fillPoly(image, [fin], (60, 60, 214))
    _frame(image)


def _mirror(image: NDArray[np.uint8]) -> None:
    image[:] = (238, 230, 214)
    cv2.line(image, (30, 150), (150, 30), (252, 250, 246), 16)
    _frame(image, (150, 150, 150))


def _cat(image: NDArray[np.uint8]) -> None:
    image[:] = (120, 190, 120)
    orange = (60, 140, 236)
    cv2.ellipse(image, (100, 170), (56, 60), 0, 0, 360, orange, -1)
    for x in (64, 136):
        ear = np.array([(x - 20, 84), (x + 20, 84), (x, 30)], np.int32)
        cv2.fillPoly(image, [ear], orange)
    cv2.circle(image, (100, 96), 50, orange, -1)
    for x in (80, 120):
        cv2.circle(image, (x, 88), 9, (60, 230, 160), -1)
        cv2.circle(image, (x, 88), 4, (20, 20, 20), -1)
    cv2.circle(image, (100, 108), 6, (120, 110, 240), -1)
    for y in (104, 114):
        cv2.line(image, (40, y), (80, 110), (30, 30, 30), 2)
        cv2.line(image, (160, y), (120, 110), (30, 30, 30), 2)
    _frame(image)


_PICTURES: dict[str, Callable[[NDArray[np.uint8]], None]] = {
    "sailing boat": _sailing_boat,
    "television": _television,
    "window": _window,
    "sun poster": _sun_poster,
    "shelf": _shelf,
    "wall clock": _wall_clock,
    "fruit": _fruit,
    "moon": _moon,
    "map": _map,
    "rocket": _rocket,
    "mirror": _mirror,
    "cat": _cat,
}
