"""A host's own sources, which a configuration names as ``package.module:Class``."""

from __future__ import annotations

import numpy as np

from wax.capture.source import BLOCK_SAMPLES, Picture, Sound
from wax.errors import SourceError


class Muted:
    """A muted microphone, whose sound card delivers a constant."""

    def __init__(self, settings: object, clock: object) -> None: ...

    def open(self) -> None: ...

    def read(self) -> Sound:
        return Sound(samples=np.full(BLOCK_SAMPLES, -300, np.int16), captured_s=0.0)

    def close(self) -> None: ...


class DeafOnTheLeft(Muted):
    """A microphone with one dead channel."""

    def read(self) -> Sound:
        left = super().read().samples
        right = left + np.tile(np.array([0, 900], np.int16), BLOCK_SAMPLES // 2)
        return Sound(samples=np.column_stack((left, right)), captured_s=0.0)


class Undated:
    """A camera without an error bound for its capture times."""

    def __init__(self, settings: object, clock: object) -> None: ...

    def open(self) -> None: ...

    def read(self) -> Picture:
        return Picture(np.zeros((72, 64), np.uint8), captured_s=0.0)

    def close(self) -> None: ...


class Dark:
    """A camera that opens and delivers nothing."""

    closed = 0

    def __init__(self, settings: object, clock: object) -> None: ...

    def open(self) -> None: ...

    def read(self) -> Picture:
        raise SourceError("It delivers no picture; check its cable.")

    def close(self) -> None:
        Dark.closed += 1
