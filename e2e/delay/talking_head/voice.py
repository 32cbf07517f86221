"""The voice: sentences by espeak-ng with real pauses between them."""

from __future__ import annotations

import io
import subprocess
from typing import TYPE_CHECKING, Final

import av
import numpy as np

from e2e.measure.errors import NotRunError

if TYPE_CHECKING:
    from numpy.typing import NDArray

RATE_HZ: Final = 48_000
FPS: Final = 30
SILENCE_S: Final = 0.5
"""At both ends, so that the seam of the loop is two closed lips."""

SENTENCES: Final = (
    (150, 0.70, "Hello! Look at my lips, and listen."),
    (125, 1.10, "Nobody likes a voice that comes from somewhere else."),
    (170, 0.35, "Up. Down. Left, and then right again."),
    (140, 0.85, "A robot rolled through the open door, stopped, and waited."),
    (115, 0.50, "Why?"),
    (160, 1.30, "Because the people who were driving it could not see the stairs."),
    (135, 0.60, "Ten, seven, five hundred, forty two."),
    (175, 0.95, "Perhaps tomorrow, or on Wednesday afternoon, it will come back to us."),
    (120, 0.40, "Good bye, and thank you."),
)
"""Words a minute, the pause before the sentence in seconds beyond the silence, and the words.

Uneven on purpose: a voice that repeats its rhythm would fit itself at a wrong shift too.
"""

_PEAK: Final = 0.7
_QUIET: Final = 0.01
"""Of full scale: what espeak-ng says less loudly than this about a sentence is cut off."""


def speak() -> NDArray[np.int16]:
    """Return the whole voice at `RATE_HZ`, mono, a whole number of pictures long.

    Raises `NotRunError` where espeak-ng is missing or fails.
    """
    pieces = [_silence(SILENCE_S)]
    for words_per_minute, pause_s, words in SENTENCES:
        pieces += [_silence(pause_s), _trim(_espeak(words, words_per_minute))]
    samples = sum(map(len, pieces)) + len(_silence(SILENCE_S))
    pieces.append(_silence(SILENCE_S + -samples % (RATE_HZ // FPS) / RATE_HZ))
    voice = np.concatenate(pieces)
    return np.asarray(np.rint(voice * (_PEAK * 32767 / np.abs(voice).max())), np.int16)


def _espeak(words: str, words_per_minute: int) -> NDArray[np.float64]:
    """One sentence, 1 is full scale."""
    command = ["espeak-ng", "-v", "en-gb", "-s", str(words_per_minute), "--stdout", words]
    try:
        wav = subprocess.run(command, capture_output=True, timeout=30, check=True).stdout
        resampler = av.AudioResampler(format="s16", layout="mono", rate=RATE_HZ)
        with av.open(io.BytesIO(wav), "r") as container:
            frames = [
                out for frame in container.decode(audio=0) for out in resampler.resample(frame)
            ]
    except FileNotFoundError as error:
        raise NotRunError(
            "The film has no voice: espeak-ng is not installed; install the package espeak-ng."
        ) from error
    except (OSError, subprocess.SubprocessError, av.FFmpegError) as error:
        raise NotRunError(
            f"The film has no voice: espeak-ng failed ({error}); try it by hand: espeak-ng hello."
        ) from error
    frames += resampler.resample(None)
    return np.concatenate([frame.to_ndarray()[0] for frame in frames]) / 32768.0


def _trim(sound: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the sentence without the silence about it."""
    loud = np.flatnonzero(np.abs(sound) > _QUIET)
    return sound[loud[0] : loud[-1] + 1] if len(loud) else sound[:0]


def _silence(seconds: float) -> NDArray[np.float64]:
    return np.zeros(round(seconds * RATE_HZ))
