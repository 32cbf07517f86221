"""How good speech sounds: a voice to play, and ViSQOL's score of what was heard of it.

ViSQOL v3 (Chinen et al., "ViSQOL v3: An Open Source Production Ready Objective Speech and Audio
Metric", 2020) compares spectrograms, patch by patch; it wants some seconds at 16 kHz. So each
sentence is found in the recording where it correlates best, once in each turn of the film.
"""

from __future__ import annotations

import hashlib
import importlib
import io
import os
import subprocess
import tempfile
from fractions import Fraction
from functools import cache
from pathlib import Path
from statistics import fmean
from typing import TYPE_CHECKING, Any, Final

import av
import numpy as np

from e2e.measure.errors import NotRunError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Sound = NDArray[np.float64]

RATE_HZ: Final = 48_000
FPS: Final = 30
SPEECH_HZ: Final = 16_000
SILENCE_S: Final = 0.5
"""At both ends of the voice."""
_SIZE: Final = (480, 640)
_BLOCK: Final = 16
_PIXELS_A_PICTURE: Final = 2
"""So fast a pattern moves, which gives the encoder as much to do as a scene does."""
_PAUSE_S: Final = 0.3
_SHORTEST_S: Final = 1.5
"""Of less ViSQOL says little."""
_AROUND_S: Final = 0.1
"""So much silence at both ends is compared, too."""

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

Uneven on purpose: a voice that repeats its rhythm would fit itself at a wrong place too.
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


def film_file(folder: Path) -> Path:
    """Return a film of the voice in `folder`, made if it is not there.

    H.264 and FLAC in MP4, exact in its time stamps. Any number may do this at the same time.
    Raises `NotRunError` where espeak-ng is missing.
    """
    voice = speak()
    content = hashlib.sha256(voice.tobytes() + Path(__file__).read_bytes())
    film = folder / f"speech-{content.hexdigest()[:12]}.mp4"
    if not film.exists():
        folder.mkdir(parents=True, exist_ok=True)
        handle, unfinished = tempfile.mkstemp(suffix=".mp4", prefix=".film-", dir=folder)
        os.close(handle)
        try:
            _write(Path(unfinished), voice)
            Path(unfinished).chmod(0o644)
            Path(unfinished).replace(film)
        finally:
            Path(unfinished).unlink(missing_ok=True)
    return film


def _write(path: Path, voice: NDArray[np.int16]) -> None:
    """Write it; both streams begin at 0 and are equally long."""
    blocks = np.random.default_rng(2004).integers(16, 236, [side // _BLOCK for side in _SIZE])
    pattern = np.kron(blocks, np.ones((_BLOCK, _BLOCK))).astype(np.uint8)
    with av.open(str(path), "w", options={"movflags": "+faststart"}) as container:
        pictures: Any = container.add_stream("libx264", rate=FPS)
        pictures.height, pictures.width = _SIZE
        pictures.pix_fmt = "yuv420p"
        pictures.codec_context.time_base = Fraction(1, FPS)
        # No picture waits for a later one, and a server that fell behind soon finds a keyframe.
        pictures.options = {"preset": "ultrafast", "crf": "14", "bf": "0", "g": str(FPS)}
        sound: Any = container.add_stream("flac", rate=RATE_HZ, layout="mono")
        per_picture = RATE_HZ // FPS
        for number in range(len(voice) // per_picture):
            moved = np.roll(pattern, number * _PIXELS_A_PICTURE, axis=1)
            picture = av.VideoFrame.from_ndarray(moved, format="gray").reformat(format="yuv420p")
            picture.pts, picture.time_base = number, Fraction(1, FPS)
            container.mux(pictures.encode(picture))
            start = number * per_picture
            piece = av.AudioFrame.from_ndarray(
                voice[None, start : start + per_picture], format="s16", layout="mono"
            )
            piece.sample_rate, piece.pts = RATE_HZ, start
            piece.time_base = Fraction(1, RATE_HZ)
            container.mux(sound.encode(piece))
        container.mux(pictures.encode(None))
        container.mux(sound.encode(None))


def speech_quality(voice: NDArray[np.int16], heard: Sequence[NDArray[np.float32]]) -> float | None:
    """Return the mean opinion score, 1 to 5, over all sentences in what was `heard` at 48 kHz.

    None where no sentence was heard to its end. Raises `NotRunError` without ViSQOL.
    """
    visqol = judge()
    if not heard:
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
def judge() -> Any:
    """Return ViSQOL; raises `NotRunError`."""
    try:
        visqol = importlib.import_module("visqol")  # is built from source, which not all can
    except ImportError as error:
        raise NotRunError(
            "ViSQOL is not installed: uv pip install --require-hashes -r .make/speech.lock"
        ) from error
    api = visqol.VisqolApi()
    api.create(mode="speech", use_lattice_model=False)
    return api
