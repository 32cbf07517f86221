"""libx264 instead of hardware: a real encoder that meets the requirements or violates one."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from wax.capture.source import Picture
from wax.config.video import RenditionSettings
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
"""An encoder that looks ahead."""
HIGH: Final = replace(GOOD, options={"preset": "veryfast", "tune": "zerolatency"})
"""An encoder with a profile that was not negotiated."""
ODD: Final = replace(GOOD, pixels="nv12")
"""An encoder with another pixel format."""


def picture(number: int, size: tuple[int, int] = (160, 120)) -> Picture:
    """Return a moving picture, at 30 a second."""
    width, height = size
    i420 = np.full((height * 3 // 2, width), 128, np.uint8)
    i420[:height] = (np.arange(width) + 3 * number) % 200
    return Picture(i420, 5000 + number / 30)
