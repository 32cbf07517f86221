"""The simulated robot's lamp, and its light in the picture (pure)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Final

import cv2
import numpy as np

from wax.robot.simulated.view import HORIZON

if TYPE_CHECKING:
    from numpy.typing import NDArray

LIGHTS: Final = {
    "white": (1.0, 1.0, 1.0),
    "warm": (0.55, 0.85, 1.0),
    "red": (0.1, 0.15, 1.0),
}
"""The blue, green and red parts of each light."""
FULL: Final = 100.0
_GAIN: Final = 0.9
"""How much brighter full light makes the middle of the picture."""
_BEAM: Final = 0.35
"""The beam's radius, as a share of the picture's width."""


@dataclass(frozen=True, slots=True)
class Lamp:
    """Whether the lamp is on, its brightness in percent, and its kind of light."""

    is_on: bool = False
    brightness: float = FULL
    light: str = "white"


def lit(image: NDArray[np.uint8], lamp: Lamp) -> NDArray[np.uint8]:
    """Return the BGR picture as it looks in the lamp's beam."""
    if not lamp.is_on:
        return image
    height, width, _ = image.shape
    gains = _beam(width, height, lamp.brightness, lamp.light)
    return np.asarray(cv2.multiply(image, gains, dtype=cv2.CV_8U), np.uint8)


@lru_cache(maxsize=4)
def _beam(width: int, height: int, brightness: float, light: str) -> NDArray[np.float32]:
    """Return the brightening of each pixel and colour."""
    x = (np.arange(width) + 0.5 - width / 2) / width
    y = (np.arange(height) + 0.5 - height * HORIZON) / width
    spread = np.exp(-(x[None, :] ** 2 + y[:, None] ** 2) / (2 * _BEAM**2))
    gain = _GAIN * max(0.0, min(1.0, brightness / FULL))
    return np.asarray(1.0 + gain * spread[..., None] * np.array(LIGHTS[light]), np.float32)
