"""A host's colour, made legible in both themes. Pure.

Contrast is measured as in WCAG 2.2. The page's backgrounds are fixed, so a colour too pale for the
light ones or too dark for the dark ones is mixed with black or white until it is legible; its hue
stays.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

Colour = tuple[float, float, float]
"""Red, green and blue, each from 0 to 1, as in ``#rrggbb``."""

BLACK: Final[Colour] = (0.0, 0.0, 0.0)
WHITE: Final[Colour] = (1.0, 1.0, 1.0)

TEXT_CONTRAST: Final = 4.5
"""WCAG 2.2, 1.4.3; 3 : 1 would do for anything but text, but the accent colours text, too."""

_MARGIN: Final = 0.1
"""For rounding to ``#rrggbb``."""
_STEPS: Final = 256

_LIGHT_GROUNDS: Final = ("#ffffff", "#f3f4f1", "#e9ece8")
_DARK_GROUNDS: Final = ("#121615", "#1b211f", "#262e2b")
"""The page's background, surface and sunken surface in each theme, as in its style sheet."""


@dataclass(frozen=True, slots=True)
class Shades:
    """One theme's accent, the accent pressed, the text on both, and backgrounds of its hue.

    `driving` lies under white text, `calm` under the page's own.
    """

    accent: str
    press: str
    on_accent: str
    driving: str
    calm: str


def parsed(text: str) -> Colour:
    """Parse ``#rrggbb``."""
    red, green, blue = (int(text[at : at + 2], 16) / 255 for at in (1, 3, 5))
    return red, green, blue


def written(colour: Colour) -> str:
    """Write ``#rrggbb``."""
    return "#" + "".join(f"{round(part * 255):02x}" for part in colour)


def contrast(one: Colour, other: Colour) -> float:
    """Return the contrast of two colours, from 1 to 21."""
    darker, lighter = sorted((_luminance(one), _luminance(other)))
    return (lighter + 0.05) / (darker + 0.05)


def light(accent: str) -> Shades:
    """Return a colour's shades for the light theme."""
    legible = _towards(BLACK, parsed(accent), _LIGHT_GROUNDS)
    return Shades(
        accent=written(legible),
        press=written(_mixed(legible, BLACK, 0.3)),
        on_accent=written(WHITE),
        driving=_under_white(accent),
        calm=written(_mixed(WHITE, legible, 0.13)),
    )


def dark(accent: str) -> Shades:
    """Return a colour's shades for the dark theme."""
    legible = _towards(WHITE, parsed(accent), _DARK_GROUNDS)
    return Shades(
        accent=written(legible),
        press=written(_mixed(legible, WHITE, 0.4)),
        on_accent="#0a0f0d",
        driving=_under_white(accent),
        calm=written(_mixed(parsed(_DARK_GROUNDS[0]), legible, 0.2)),
    )


def _under_white(accent: str) -> str:
    return written(_towards(BLACK, parsed(accent), (written(WHITE),)))


def _towards(end: Colour, colour: Colour, grounds: tuple[str, ...]) -> Colour:
    """Mix a colour with the least of `end` that makes it legible on all these backgrounds."""
    for step in range(_STEPS):
        mixed = _mixed(colour, end, step / _STEPS)
        if all(contrast(mixed, parsed(one)) >= TEXT_CONTRAST + _MARGIN for one in grounds):
            return mixed
    return end


def _mixed(one: Colour, other: Colour, share: float) -> Colour:
    red, green, blue = (a + (b - a) * share for a, b in zip(one, other, strict=True))
    return red, green, blue


def _luminance(colour: Colour) -> float:
    """Return the relative luminance (WCAG 2.2)."""
    red, green, blue = (
        part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in colour
    )
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue
