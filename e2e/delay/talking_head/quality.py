"""How good the voice sounds: ViSQOL's score of what was heard against what was said.

ViSQOL v3 (Chinen et al., "ViSQOL v3: An Open Source Production Ready Objective Speech and Audio
Metric", 2020) compares spectrograms, patch by patch; it wants some seconds at 16 kHz. So each
sentence is found in the recording where it correlates best, once in each turn of the film.
"""

from __future__ import annotations

import importlib
from functools import cache
from statistics import fmean
from typing import TYPE_CHECKING, Any, Final

import av
import numpy as np

from e2e.delay.talking_head.voice import RATE_HZ

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Sound = NDArray[np.float64]

SPEECH_HZ: Final = 16_000
_PAUSE_S: Final = 0.3
_SHORTEST_S: Final = 1.5
"""Of less ViSQOL says little."""
_AROUND_S: Final = 0.1
"""So much silence at both ends is compared, too."""


def speech_quality(voice: NDArray[np.int16], heard: Sequence[NDArray[np.float32]]) -> float | None:
    """Return the mean opinion score, 1 to 5, over all sentences in what was `heard` at 48 kHz.

    None where ViSQOL is not installed, or no sentence was heard to its end.
    """
    visqol = _visqol()
    if visqol is None or not heard:
        return None
    said, recorded = at_16_khz(voice / 32768.0), at_16_khz(np.concatenate(heard))
    scores = [
        visqol.measure_from_arrays(sentence, recorded[at : at + len(sentence)], SPEECH_HZ).moslqo
        for sentence in sentences(said)
        for at in places(sentence, recorded, len(said))
    ]
    return fmean(scores) if scores else None


def sentences(said: Sound) -> list[Sound]:
    """Cut the voice where it pauses; each has a little of the silence about it."""
    loud = np.flatnonzero(np.abs(said) > 0.001)
    ends = np.flatnonzero(np.diff(loud) > _PAUSE_S * SPEECH_HZ)
    begins = [loud[0], *loud[ends + 1]]
    around = round(_AROUND_S * SPEECH_HZ)
    cut = [
        said[max(begin - around, 0) : end + around]
        for begin, end in zip(begins, [*loud[ends], loud[-1]], strict=True)
    ]
    return [sentence for sentence in cut if len(sentence) >= _SHORTEST_S * SPEECH_HZ]


def places(sentence: Sound, recorded: Sound, period: int) -> list[int]:
    """Return where the sentence begins in the recording, once in each whole period of it."""
    room = len(recorded) - len(sentence)
    if room < period:
        return []
    size = 1 << (len(recorded) + len(sentence) - 1).bit_length()
    spectrum = np.fft.rfft(recorded, size) * np.conj(np.fft.rfft(sentence, size))
    alike = np.fft.irfft(spectrum, size)[: room + 1]
    return [
        begin + int(np.argmax(alike[begin : begin + period]))
        for begin in range(0, room + 1 - period, period)
    ]


def at_16_khz(sound: Sound | NDArray[np.float32]) -> Sound:
    """Resample from 48 kHz."""
    resampler = av.AudioResampler(format="fltp", layout="mono", rate=SPEECH_HZ)
    frame = av.AudioFrame.from_ndarray(
        np.asarray(sound, np.float32)[None, :], format="fltp", layout="mono"
    )
    frame.sample_rate = RATE_HZ
    frames = [*resampler.resample(frame), *resampler.resample(None)]
    return np.concatenate([one.to_ndarray()[0] for one in frames]).astype(np.float64)


@cache
def _visqol() -> Any:
    try:
        visqol = importlib.import_module("visqol")  # is built from source, which not all can
    except ImportError:
        return None
    api = visqol.VisqolApi()
    api.create(mode="speech", use_lattice_model=False)
    return api
