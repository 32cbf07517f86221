"""What the radio in the flat plays (pure): a voice singing Beethoven's Ode to Joy, in a loop."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Final

import numpy as np

from wax.capture.source import SAMPLE_RATE_HZ
from wax.robot.simulated.through_walls import muffled

if TYPE_CHECKING:
    from numpy.typing import NDArray

LEVEL_RMS = 0.1
"""The radio's loudness at one metre, full scale being 1."""

_BEAT_S: Final = 0.4
_C4_HZ: Final = 261.63
_FIRST: Final = ((4, 1), (4, 1), (5, 1), (7, 1), (7, 1), (5, 1), (4, 1), (2, 1))
_SECOND: Final = ((0, 1), (0, 1), (2, 1), (4, 1))
_MELODY: Final = (
    *(*_FIRST, *_SECOND, (4, 1.5), (2, 0.5), (2, 2)),
    *(*_FIRST, *_SECOND, (2, 1.5), (0, 0.5), (0, 2)),
)
_BASS: Final = ((0, 4), (-5, 4), (0, 4), (-5, 4), (0, 4), (-5, 4), (0, 2), (-5, 2), (0, 4))
_VOWELS_HZ: Final = ((750.0, 1150.0, 2450.0), (480.0, 850.0, 2400.0), (300.0, 2200.0, 2900.0))
"""The formants of a, o and i, which make it sound like a voice."""


class Radio:
    """Plays the loop at its place."""

    def __init__(self, place: tuple[float, float]) -> None:
        self.place = place
        self._clear, self._muffled = tune()
        self._at = 0

    def play(self, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the next `count` samples, and the same as they come through a wall."""
        places = np.arange(self._at, self._at + count) % len(self._clear)
        self._at += count
        return self._clear[places].astype(np.float64), self._muffled[places].astype(np.float64)


@cache
def tune() -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Compose the loop: clear, and as heard through a wall; both end where they begin."""
    beats = sum(length for _, length in _MELODY)
    song = np.zeros(round(beats * _BEAT_S * SAMPLE_RATE_HZ))
    at = 0.0
    for number, (note, length) in enumerate(_MELODY):
        _add(song, at, _sung(_hz(note), length * _BEAT_S, _VOWELS_HZ[number % len(_VOWELS_HZ)]))
        at += length
    at = 0.0
    for note, length in _BASS:
        _add(song, at, 0.35 * _plucked(_hz(note - 12), length * _BEAT_S))
        at += length
    song *= LEVEL_RMS / np.sqrt(np.mean(song**2))
    return song.astype(np.float32), muffled(song).astype(np.float32)


def _hz(semitones: float) -> float:
    return float(_C4_HZ * 2.0 ** (semitones / 12.0))


def _add(song: NDArray[np.float64], beat: float, sound: NDArray[np.float64]) -> None:
    start = round(beat * _BEAT_S * SAMPLE_RATE_HZ)
    song[start : start + len(sound)] += sound[: len(song) - start]


def _sung(pitch_hz: float, length_s: float, formants: tuple[float, ...]) -> NDArray[np.float64]:
    time_s = np.arange(round(length_s * SAMPLE_RATE_HZ)) / SAMPLE_RATE_HZ
    phase = 2 * np.pi * pitch_hz * time_s + 0.25 * np.sin(2 * np.pi * 5.5 * time_s)
    voice = np.zeros_like(time_s)
    for harmonic in range(1, int(3500.0 / pitch_hz) + 1):
        tone_hz = harmonic * pitch_hz
        strength = sum(1.0 / (1.0 + ((tone_hz - peak) / 130.0) ** 2) for peak in formants)
        voice += (0.15 + strength) / harmonic * np.sin(harmonic * phase)
    return voice * _envelope(time_s, length_s)


def _plucked(pitch_hz: float, length_s: float) -> NDArray[np.float64]:
    time_s = np.arange(round(length_s * SAMPLE_RATE_HZ)) / SAMPLE_RATE_HZ
    waves = (np.sin(2 * np.pi * n * pitch_hz * time_s) / n**1.5 for n in range(1, 6))
    string = np.sum(list(waves), axis=0) * np.exp(-2.0 * time_s)
    return np.asarray(string * _envelope(time_s, length_s))


def _envelope(time_s: NDArray[np.float64], length_s: float) -> NDArray[np.float64]:
    """Rise in 15 ms and be silent again at the end, so that notes join without a click."""
    rise, fall = np.minimum(1.0, time_s / 0.015), np.minimum(1.0, (length_s - time_s) / 0.06)
    return np.asarray(rise * np.maximum(0.0, fall))
