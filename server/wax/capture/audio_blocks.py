"""Cut sound of any piece length into 10 ms blocks on an even timeline.

The encoder needs blocks of one length, and synchronisation needs evenly spaced capture times, but a
sound card's own times jitter by milliseconds and its crystal drifts from our clock.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from wax.capture.channels import channels_of, with_channels
from wax.capture.source import BLOCK_SAMPLES, SAMPLE_RATE_HZ, Sound

if TYPE_CHECKING:
    from numpy.typing import NDArray

_JITTER_S: Final = 0.1
"""A capture time that is off by up to this is jitter or drift; beyond, a gap or an overlap."""

_JUMP_S: Final = 1.0
"""Longer gaps are not filled: the timeline restarts where the sound does."""

_FOLLOW: Final = 0.01
_FOLLOW_MAX_S: Final = 0.00005
"""A block's length on the timeline differs from 10 ms by at most this (0.5 %)."""


class Blocks:
    """Turns pieces of sound into whole blocks. Pure.

    * No sample is lost or added while capture times fit the number of samples within 100 ms; the
      blocks' times then advance by 10 ms, each corrected by at most 0.05 ms towards the measured
      ones.
    * A gap of up to 1 s is filled with silence; sound up to 1 s too early overlaps what was already
      delivered and is dropped. So the delay never grows.
    * After a jump of more than 1 s either way the timeline restarts and an incomplete block is
      dropped.
    * So it does after `restart`, however short the gap.
    * A block has as many channels as the newest piece in it.
    """

    def __init__(self) -> None:
        self._waiting: list[NDArray[np.int16]] = []
        self._count = 0
        self._head_s: float | None = None
        self.filled_samples = 0
        self.dropped_samples = 0

    @property
    def filled_ms(self) -> int:
        """How much silence has filled gaps since the start."""
        return self.filled_samples * 1000 // SAMPLE_RATE_HZ

    @property
    def dropped_ms(self) -> int:
        """How much sound has been dropped since the start."""
        return self.dropped_samples * 1000 // SAMPLE_RATE_HZ

    def restart(self) -> None:
        """Begin a new timeline with the next piece."""
        self._head_s = None

    def push(self, sound: Sound) -> list[Sound]:
        """Add a piece of sound of any length and return the blocks that it completes."""
        samples = sound.samples
        error_s = self._error_s(sound.captured_s)
        if error_s is None or abs(error_s) > _JUMP_S:
            self._begin(sound.captured_s)
        elif error_s > _JITTER_S:
            missing = round(error_s * SAMPLE_RATE_HZ)
            self.filled_samples += missing
            self._append(np.zeros((missing, *samples.shape[1:]), np.int16))
        elif error_s < -_JITTER_S:
            early = min(round(-error_s * SAMPLE_RATE_HZ), len(samples))
            self.dropped_samples += early
            samples = samples[early:]
        elif self._head_s is not None:
            share = min(1.0, len(samples) / BLOCK_SAMPLES)
            self._head_s += share * min(max(error_s * _FOLLOW, -_FOLLOW_MAX_S), _FOLLOW_MAX_S)
        self._append(samples)
        return self._cut()

    def _error_s(self, captured_s: float) -> float | None:
        """How much later than expected the next sample was captured; None at the start."""
        if self._head_s is None:
            return None
        return captured_s - (self._head_s + self._count / SAMPLE_RATE_HZ)

    def _begin(self, captured_s: float) -> None:
        self.dropped_samples += self._count
        self._waiting.clear()
        self._count = 0
        self._head_s = captured_s

    def _append(self, samples: NDArray[np.int16]) -> None:
        channels = channels_of(samples)
        self._waiting = [with_channels(one, channels) for one in self._waiting]
        self._waiting.append(samples)
        self._count += len(samples)

    def _cut(self) -> list[Sound]:
        if self._head_s is None or self._count < BLOCK_SAMPLES:
            return []
        joined = np.concatenate(self._waiting)
        blocks = []
        while len(joined) >= BLOCK_SAMPLES:
            blocks.append(Sound(samples=joined[:BLOCK_SAMPLES], captured_s=self._head_s))
            joined = joined[BLOCK_SAMPLES:]
            self._head_s += BLOCK_SAMPLES / SAMPLE_RATE_HZ
        self._waiting = [joined]
        self._count = len(joined)
        return blocks
