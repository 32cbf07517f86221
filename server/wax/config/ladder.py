"""The ladder of renditions for a camera whose own is `"auto"`. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Sequence


class Rung(NamedTuple):
    """One step: an even size, pictures and bits a second."""

    width: int
    height: int
    fps: float
    bitrate_bps: int


class RateStep(NamedTuple):
    """A step of every ladder: its rate, the longer side at most, and pictures a second at most."""

    bitrate_bps: int
    longest: int
    fps: float


DRIVING: Final = (
    RateStep(2_500_000, 1280, 30.0),
    RateStep(1_000_000, 960, 30.0),
    RateStep(600_000, 640, 30.0),
    RateStep(300_000, 320, 30.0),
    RateStep(120_000, 320, 15.0),
    RateStep(50_000, 160, 15.0),
    RateStep(16_000, 160, 10.0),
)
"""At each rate the size that is sharpest in motion, by SSIM: VP8's larger ones are blurred there.
The last step still lets people drive over a telephone modem."""

BESIDE: Final = (RateStep(200_000, 320, 15.0), RateStep(30_000, 160, 5.0))
"""For a camera beside the driving view; the last step is that of the small picture."""

_FPS: Final = 30.0
_VGA_BPS: Final = 1_000_000
_VGA_PIXELS: Final = 640 * 480
_GROWTH: Final = 0.834
"""A larger picture needs fewer bits for each pixel: 1280×720 has 2.5 times the rate of 640×480."""
_LEAST_BPS: Final = 10_000
_MOST_BPS: Final = 20_000_000
_LEAST_SIDE: Final = 32
_NEAR: Final = 0.7
"""A step at more than this part of the rate of the one above would be an encoder for nothing."""
_ALIKE: Final = 1.2
"""A size that is larger by no more than this factor is not scaled, which would only blur it."""


def ladder(width: int, height: int, fps: float, steps: Sequence[RateStep] = DRIVING) -> list[Rung]:
    """Return the renditions of a camera of this even size, the best first.

    The first has the camera's own size. Each keeps its shape, to the nearest even number of pixels,
    and has no more than 30 pictures a second; the bit rate falls with every step.
    """
    fps = min(fps, _FPS)
    wanted = _VGA_BPS * (width * height / _VGA_PIXELS) ** _GROWTH * fps / _FPS
    found = [Rung(width, height, fps, round_bps(wanted))]
    for step in steps:
        own_fps = min(fps, step.fps)
        bitrate_bps = round_bps(step.bitrate_bps * own_fps / step.fps)
        if bitrate_bps <= _NEAR * found[-1].bitrate_bps:
            found.append(Rung(*_scaled(width, height, step.longest), own_fps, bitrate_bps))
    return found


def round_bps(bitrate_bps: float) -> int:
    """Return an allowed rate of two digits, as a person would write it."""
    digits: int = 10 ** max(len(str(int(bitrate_bps))) - 2, 0)
    return min(max(round(bitrate_bps / digits) * digits, _LEAST_BPS), _MOST_BPS)


def _scaled(width: int, height: int, longest: int) -> tuple[int, int]:
    scale = max(longest / max(width, height), _LEAST_SIDE / min(width, height))
    if scale * _ALIKE >= 1.0:
        return width, height
    return _even(width * scale), _even(height * scale)


def _even(pixels: float) -> int:
    return max(2 * round(pixels / 2), _LEAST_SIDE)
