"""How long the processor takes to encode a picture: the trial for a size that is left to us."""

from __future__ import annotations

import time
from statistics import median
from typing import TYPE_CHECKING, Final

import cv2
import numpy as np

from wax.capture.letterbox import black
from wax.capture.source import Picture
from wax.encode.video_encoder import VideoEncoder
from wax.machine import cores

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Literal

    from wax.config.video import RenditionSettings

_PICTURES: Final = 8
_LIMIT_S: Final = 0.35
_SHARE: Final = 0.6
_SHARE_OF_ONE: Final = 0.35
"""Encoding may take this part of a picture's time; with a single core the rest needs it, too."""
_GRAIN: Final = 16
_STEP_PX: Final = 6


def most_ms(fps: float, usable: float | None = None) -> float:
    """Return how long a picture may take so that this many a second are encoded in time."""
    usable = usable or cores.usable()
    return 1000 / fps * (_SHARE if usable >= 2 else _SHARE_OF_ONE * min(usable, 1.0))


def encode_ms(
    rendition: RenditionSettings,
    codec: Literal["vp8", "h264"],
    *,
    cpu_s: Callable[[], float] = time.thread_time,
    now_s: Callable[[], float] = time.monotonic,
) -> float:
    """Return the processor's time for a picture of a moving texture, the median of up to eight.

    It ends after a third of a second, or after the second picture of a very slow machine. The time
    of the processor, unlike that of the clock, hardly depends on what else runs.
    """
    encoder = VideoEncoder(codec=codec, rendition=rendition)
    texture = _texture(rendition.width + _PICTURES * _STEP_PX, rendition.height)
    took_s: list[float] = []
    end_s = now_s() + _LIMIT_S
    for number in range(_PICTURES + 1):
        i420 = black(rendition.width, rendition.height)
        across = number * _STEP_PX
        i420[: rendition.height] = texture[:, across : across + rendition.width]
        began_s = cpu_s()
        encoder.encode(Picture(i420, number / rendition.fps), keyframe=False)
        if number:  # the first, a keyframe, also builds the encoder
            took_s.append(cpu_s() - began_s)
        if took_s and now_s() >= end_s:
            break
    return median(took_s) * 1000


def _texture(width: int, height: int) -> np.typing.NDArray[np.uint8]:
    """Return soft random spots, as rich in detail as a room."""
    small = (height // _GRAIN + 1, width // _GRAIN + 1)
    spots = np.random.default_rng(1).integers(16, 236, small, dtype=np.uint8)
    return np.asarray(cv2.resize(spots, (width, height)), np.uint8)
