"""libx264 in the place of hardware: a real encoder that keeps what it must, or does not."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from wax.capture.source import Picture
from wax.config.settings import RenditionSettings
from wax.encode.hardware import Hardware

SMALL: Final = RenditionSettings(width=160, height=120, fps=30, bitrate_bps=200_000)
LARGE: Final = RenditionSettings(width=320, height=240, fps=30, bitrate_bps=400_000)

GOOD: Final = Hardware(
    "libx264",
    "yuv420p",
    {
        "preset": "ultrafast",
        "tune": "zerolatency",
        "profile": "baseline",
        "x264-params": "scenecut=0:sliced-threads=0:threads=1",
    },
)
LATE: Final = replace(GOOD, options={"preset": "ultrafast", "profile": "baseline"})
"""It looks ahead."""
HIGH: Final = replace(GOOD, options={"preset": "veryfast", "tune": "zerolatency"})
"""A profile that was not agreed on."""
ODD: Final = replace(GOOD, pixels="nv12")
"""It takes its pictures in another form."""


def picture(number: int, size: tuple[int, int] = (160, 120)) -> Picture:
    """Return a picture that moves, at 30 a second."""
    width, height = size
    i420 = np.full((height * 3 // 2, width), 128, np.uint8)
    i420[:height] = (np.arange(width) + 3 * number) % 200
    return Picture(i420, 5000 + number / 30)
