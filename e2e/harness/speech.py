"""A voice, and a measure of how well it is heard."""

from __future__ import annotations

import io
import shutil
import subprocess
import wave
from typing import TYPE_CHECKING, Any

import av
import numpy as np

from e2e.harness.wait import until

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from numpy.typing import NDArray

RATE_HZ = 48_000
SPOKEN_S = 12.0
HEARD_S = 4
_PIECE = 4_000
_NEAR = 320
"""Samples of 8 kHz: half a second and 40 ms."""
_BLOCK = RATE_HZ // 100
_SOUNDS = 0.01
TEXT = (
    "Please drive ahead slowly. The door on your left is open, and somebody left a chair in the "
    "corridor. Mind the cable on the floor. Stop here, turn right, and go back to the window."
)


def voice(seconds: float) -> NDArray[np.int16]:
    """Return speech, `seconds` long, at 48 kHz: espeak-ng's if it is installed, else vowels."""
    wanted = int(seconds * RATE_HZ)
    spoken = _espeak() if shutil.which("espeak-ng") else _vowels(wanted)
    return np.resize(spoken, wanted).astype(np.int16)


def unbroken(seconds: float) -> NDArray[np.int16]:
    """Return speech without its pauses, so that silence means that it is not being played."""
    spoken = voice(seconds)
    blocks = _pieces(spoken, _BLOCK)
    rms = np.sqrt(((blocks / 32768) ** 2).mean(axis=1))
    sounding = blocks[rms > _SOUNDS].reshape(-1)
    return np.resize(sounding, len(spoken)).astype(np.int16)


def read(path: Path) -> NDArray[np.int16]:
    """Read a WAV that a robot's speaker wrote."""
    with wave.open(str(path)) as file:
        return np.frombuffer(file.readframes(file.getnframes()), np.int16)


def write(path: Path, sound: NDArray[np.int16]) -> None:
    """Write a WAV for a browser's microphone to read."""
    with wave.open(str(path), "wb") as file:
        file.setparams((1, 2, RATE_HZ, 0, "NONE", ""))
        file.writeframes(sound.tobytes())


def in_order(heard: NDArray[np.int16], original: NDArray[np.int16]) -> float:
    """Return the share of half seconds of `heard` that continue the looped `original` in order.

    Each is found by its waveform, whatever else sounds; by chance one in 150 would continue so. One
    gap costs one half second, not all that follow.
    """
    loop = _telephone(original)
    places = [_place(piece, loop) for piece in _pieces(_telephone(heard), _PIECE)]
    ahead = np.diff(places) - _PIECE
    off = (ahead + len(loop) // 2) % len(loop) - len(loop) // 2
    return float(np.mean(np.abs(off) <= _NEAR))


def _telephone(sound: NDArray[np.int16]) -> NDArray[np.float64]:
    """Return the sound at 8 kHz, which carries a voice."""
    return np.asarray(_pieces(sound, 6).mean(axis=1))


def _pieces(sound: NDArray[Any], size: int) -> NDArray[Any]:
    return sound[: len(sound) // size * size].reshape(-1, size)


def _place(piece: NDArray[np.float64], loop: NDArray[np.float64]) -> int:
    """Return the place in `loop` that is most like `piece`, normalised by each place's energy."""
    alike = _slid(loop, piece)
    energy = _slid(loop**2, np.ones(len(piece)))
    return int(np.argmax(alike / np.sqrt(energy + 0.003 * energy.max())))


def _slid(loop: NDArray[np.float64], piece: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the scalar product of `piece` with each place of `loop`."""
    spectrum = np.fft.rfft(loop) * np.conj(np.fft.rfft(piece, len(loop)))
    return np.fft.irfft(spectrum, len(loop))


def _espeak() -> NDArray[np.int16]:
    spoken = subprocess.run(
        ["espeak-ng", "-v", "en", "-s", "150", "--stdout", TEXT], capture_output=True, check=True
    ).stdout
    resampler = av.AudioResampler(format="s16", layout="mono", rate=RATE_HZ)
    with av.open(io.BytesIO(spoken), "r") as wav:
        frames = [out for frame in wav.decode(audio=0) for out in resampler.resample(frame)]
    return np.concatenate([frame.to_ndarray()[0] for frame in frames])


def _vowels(samples: int) -> NDArray[np.int16]:
    """Syllables of a pulse train through three formants, with pauses of uneven length."""
    random = np.random.default_rng(2004)
    pieces: list[NDArray[np.float64]] = []
    while sum(map(len, pieces)) < samples:
        length = int(RATE_HZ * random.uniform(0.08, 0.3))
        time_s = np.arange(length) / RATE_HZ
        pitch_hz = random.uniform(90, 160)
        formants_hz = random.uniform([300, 900, 2200], [800, 1800, 3000])
        since_pulse_s = time_s % (1 / pitch_hz)
        syllable = sum(
            np.exp(-since_pulse_s * 400) * np.sin(2 * np.pi * hz * since_pulse_s)
            for hz in formants_hz
        )
        pieces += [syllable * np.hanning(length), np.zeros(int(RATE_HZ * random.uniform(0, 0.4)))]
    return np.asarray(np.concatenate(pieces)[:samples] * 6000, dtype=np.int16)


async def are_words(heard: Callable[[], NDArray[np.int16]]) -> None:
    """Wait until the newest of what is heard is the microphone's words."""
    words, enough = voice(SPOKEN_S), HEARD_S * RATE_HZ

    def are_they() -> bool:
        newest = heard()[-enough:]
        return len(newest) == enough and in_order(newest, words) >= 0.5

    await until(are_they, "the words are heard", within_s=30, every_s=0.5)
