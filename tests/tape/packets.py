"""Pictures and sound as the encoders produce them, to be recorded."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from wax.capture.source import BLOCK_SAMPLES, Picture, Sound
from wax.config.video import RenditionSettings
from wax.congestion.allocation import SoundEncoding
from wax.encode.sample_clock import SampleClock
from wax.encode.sound_encoder import SoundEncoder
from wax.encode.video_encoder import VideoEncoder

if TYPE_CHECKING:
    from collections.abc import Iterable

    from wax.encode.encoded import EncodedPicture, EncodedSound

SIZE: Final = (66, 50)
"""No multiple of 16, and with an odd number of rows of chroma."""
FPS: Final = 30
_FLASH_EVERY_S: Final = 1.0


def is_flash(at_s: float) -> bool:
    """Return whether picture and sound are brightest and loudest: a tenth of each second."""
    return at_s % _FLASH_EVERY_S < 0.1


@cache
def pictures(
    codec: Literal["vp8", "h264"], *, begin_s: float, seconds: float, keyframes_s: float = 1.0
) -> list[EncodedPicture]:
    """Return pictures, the first a keyframe, that are white during a flash."""
    width, height = SIZE
    rendition = RenditionSettings(width=width, height=height, fps=FPS, bitrate_bps=200_000)
    encoder = VideoEncoder(codec=codec, rendition=rendition)
    made = []
    for number in range(round(seconds * FPS)):
        at_s = begin_s + number / FPS
        i420 = np.full((height * 3 // 2, width), 128, np.uint8)
        i420[:height] = 235 if is_flash(at_s) else 16
        i420[0, number % width] = 90  # so that no two are equal
        due = number % round(keyframes_s * FPS) == 0
        picture = encoder.encode(Picture(i420, at_s), keyframe=due)
        assert picture is not None
        made.append(picture)
    return made


@cache
def sounds(*, begin_s: float, seconds: float, drift_ppm: float = 0.0) -> list[EncodedSound]:
    """Return 20 ms packets, loud during a flash, of a card that is too fast by `drift_ppm`."""
    encoder, clock = SoundEncoder(SoundEncoding(20, 32_000)), SampleClock()
    made = []
    for number in range(round(seconds * 100)):
        at_s = begin_s + number / 100 / (1 + drift_ppm / 1e6)
        times = np.arange(BLOCK_SAMPLES) / 48_000
        level = 12_000 if is_flash(at_s) else 0
        samples = (level * np.sin(2 * np.pi * 1000 * times)).astype(np.int16)
        sound = encoder.encode(Sound(samples, at_s), clock.stamp(at_s))
        if sound is not None:
            made.append(sound)
    return made


def in_order(items: Iterable[EncodedPicture | EncodedSound]) -> list[EncodedPicture | EncodedSound]:
    """Return pictures and sounds in the order in which they were captured."""
    return sorted(items, key=lambda one: one.captured_s)
