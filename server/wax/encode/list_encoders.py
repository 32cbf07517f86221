"""List the hardware encoders with their trials, for `wax devices`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.config.video import RenditionSettings
from wax.encode.choice import told
from wax.encode.hardware import HARDWARE
from wax.encode.trials import try_all

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from wax.encode.hardware import Hardware
    from wax.encode.trial import Trial

_SIZES: Final = [
    RenditionSettings(width=1280, height=720, fps=30, bitrate_bps=2_500_000),
    RenditionSettings(width=640, height=480, fps=30, bitrate_bps=1_000_000),
]


def list_encoders(
    try_all: Callable[[Sequence[Hardware], Sequence[RenditionSettings]], list[Trial]] = try_all,
) -> list[str]:
    """Return printable lines: each hardware encoder, and whether it works here."""
    lines = ['Hardware encoders, for [video] codec = "h264":']
    return lines + [f"  {one.encoder:<13} {told(one)}" for one in try_all(HARDWARE, _SIZES)]
