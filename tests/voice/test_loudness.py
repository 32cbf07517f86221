"""Concealing, limiting and gating a voice."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from wax.voice.concealment import Concealer
from wax.voice.limiter import CEILING, Limiter, SilenceGate

if TYPE_CHECKING:
    from numpy.typing import NDArray

RATE_HZ = 48_000


def tone(hz: float, samples: int, *, level: float = 0.1, start: int = 0) -> NDArray[np.int16]:
    phase = 2 * np.pi * hz * (start + np.arange(samples)) / RATE_HZ
    return np.asarray(np.round(32_767 * level * np.sin(phase)), np.int16)


def rms(samples: NDArray[np.int16]) -> float:
    return float(np.sqrt(np.mean(samples.astype(np.float64) ** 2)))


@pytest.mark.parametrize("hz", [100.0, 150.0, 240.0])
def test_a_lost_packet_goes_on_as_the_voice_did(hz: float) -> None:
    """20 ms of a lost tone are replaced by the same tone, in phase and only a little quieter."""
    concealer = Concealer()
    concealer.join(tone(hz, 4800))
    made = concealer.conceal(960)
    wanted = tone(hz, 960, start=4800)
    likeness = np.corrcoef(made, wanted)[0, 1]
    assert likeness > 0.9
    assert 0.6 * rms(wanted) < rms(made) < rms(wanted)


def test_it_fades_to_silence() -> None:
    """After 60 ms concealment is silent."""
    concealer = Concealer()
    concealer.join(tone(150, 4800))
    parts = [concealer.conceal(480) for _ in range(8)]
    loud = [rms(part) for part in parts]
    assert loud[:7] == sorted(loud[:7], reverse=True)
    assert loud[6] == loud[7] == 0


def test_what_follows_joins_without_a_click() -> None:
    """No step between two samples is much larger than the voice's own."""
    concealer = Concealer()
    first = concealer.join(tone(150, 4800, level=0.5))
    made = concealer.conceal(960)
    then = concealer.join(tone(150, 960, level=0.5, start=4800 + 960 + 100))
    whole = np.concatenate((first, made, then)).astype(np.int64)
    own = np.abs(np.diff(first.astype(np.int64))).max()
    assert np.abs(np.diff(whole)).max() < 6 * own


def test_nothing_is_made_up_of_nothing() -> None:
    """Before the first word and after a reset, concealment is silence."""
    concealer = Concealer()
    assert not concealer.conceal(960).any()
    concealer.join(tone(150, 4800))
    concealer.reset()
    assert not concealer.conceal(960).any()


PIECE = arrays.arrays(np.int16, st.integers(0, 5760))


@given(st.lists(PIECE, max_size=4))
def test_no_sound_is_beyond_the_ceiling(pieces: list[NDArray[np.int16]]) -> None:
    """Whatever the input, no sample exceeds −6 dB of full scale, and their number is kept."""
    limiter = Limiter()
    for piece in pieces:
        limited = limiter.limit(piece)
        assert limited.dtype == np.int16
        assert limited.shape == piece.shape
        assert len(limited) == 0 or np.abs(limited.astype(np.int64)).max() <= CEILING


def test_noise_at_full_scale_is_brought_down() -> None:
    """Noise at full scale is no louder than a raised voice from the first piece on."""
    noise = np.random.default_rng(1).integers(-32_768, 32_768, (50, 960)).astype(np.int16)
    limiter = Limiter()
    for piece in noise:
        assert rms(limiter.limit(piece)) < 32_768 * 10 ** (-19 / 20)


def test_speech_passes_as_it_is() -> None:
    """Sound that is not too loud passes unchanged."""
    quiet = tone(200, 960, level=0.1)
    assert np.array_equal(Limiter().limit(quiet), quiet)


def test_after_a_shout_speech_comes_back() -> None:
    """Half a second after a shout speech is as loud as before."""
    limiter = Limiter()
    limiter.limit(tone(200, 960, level=1.0))
    quiet = tone(200, 960, level=0.1)
    for _ in range(25):
        last = limiter.limit(quiet)
    assert np.array_equal(last, quiet)


def test_silence_is_left_out_after_a_while() -> None:
    """A pause within a sentence is played, long silence is not."""
    gate = SilenceGate()
    silence = np.zeros(960, np.int16)
    assert not gate.opens(silence)
    assert gate.opens(tone(200, 960))
    opened = [gate.opens(silence) for _ in range(30)]
    assert opened == [True] * 14 + [False] * 16
    assert gate.opens(tone(200, 960, level=0.01))
