"""Where things are in the window, and whether one hides another."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from playwright.async_api import FloatRect

THUMB_PX: Final = 48
LAYOUTS: Final = ((1280, 800), (900, 560), (390, 844), (844, 390))
"""A large window, the smallest that counts as one, and a phone held upright and across."""
UPRIGHT: Final = ((320, 480), (320, 568), (360, 640))
SMALL: Final = (*UPRIGHT, (320, 256), (400, 300), (480, 320), (800, 560))

STOP_IS_WHOLE: Final = """() => {
    const stop = document.querySelector(".stop-button");
    const { left, right, top, bottom } = stop.getBoundingClientRect();
    const across = [left + 8, (left + right) / 2, right - 8];
    const along = [top + 8, (top + bottom) / 2, bottom - 8];
    const isIn = left >= 0 && top >= 0 && right <= innerWidth && bottom <= innerHeight;
    const isHit = (x, y) => stop.contains(document.elementFromPoint(x, y));
    return isIn && across.every((x) => along.every((y) => isHit(x, y)));
}"""


def overlap(one: FloatRect, other: FloatRect) -> bool:
    return (
        one["x"] < other["x"] + other["width"]
        and other["x"] < one["x"] + one["width"]
        and one["y"] < other["y"] + other["height"]
        and other["y"] < one["y"] + one["height"]
    )


def is_within(box: FloatRect, width: int, height: int) -> bool:
    return (
        box["x"] >= 0
        and box["y"] >= 0
        and box["x"] + box["width"] <= width
        and box["y"] + box["height"] <= height
    )
