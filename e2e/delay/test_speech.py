"""The score of the voice: each sentence is found where it was heard, and holes cost some of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import av
import numpy as np
import pytest

from e2e.delay.speech import (
    FPS,
    RATE_HZ,
    SPEECH_HZ,
    at_16_khz,
    film_file,
    places,
    sentences,
    speak,
    speech_quality,
)

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray


@pytest.fixture(scope="module")
def voice() -> NDArray[np.int16]:
    return speak()


def test_a_film_plays_the_voice_and_moves(voice: NDArray[np.int16], tmp_path: Path) -> None:
    """Sound for sound and picture for picture; both are equally long, and made once."""
    film = film_file(tmp_path)
    with av.open(str(film)) as container:
        pictures = sum(1 for _ in container.decode(video=0))
    with av.open(str(film)) as container:
        heard = np.concatenate([one.to_ndarray() for one in container.decode(audio=0)], axis=1)
    assert pictures == len(voice) * FPS // RATE_HZ
    assert np.array_equal(np.asarray(heard, np.int32).ravel(), voice)
    assert film_file(tmp_path) == film


def test_each_sentence_is_found_in_each_turn_of_the_film(voice: NDArray[np.int16]) -> None:
    """Whatever was heard before, and with some noise, to the sample; a part of a turn has none."""
    said = at_16_khz(voice / 32768.0)
    noise = np.random.default_rng(1).normal(0, 0.01, 3 * len(said))
    recorded = np.roll(np.tile(said, 3), 5000) + noise
    cut = sentences(said)
    assert len(cut) >= 6
    assert all(1.5 <= len(sentence) / SPEECH_HZ <= 8 for sentence in cut)
    for sentence in cut:
        found = places(sentence, recorded, len(said))
        assert len(found) == 2
        for at in found:
            assert np.corrcoef(sentence, recorded[at : at + len(sentence)])[0, 1] > 0.9
        assert places(sentence, recorded[: len(said)], len(said)) == []


def test_holes_and_noise_score_less(voice: NDArray[np.int16]) -> None:
    """The voice itself scores best, with a tenth of it silent less; nothing heard has no score."""
    pytest.importorskip("visqol", reason="make delay installs it")
    heard = np.tile(voice.astype(np.float32) / np.float32(32768), 2)
    holes = heard.copy()
    for begin in range(0, len(holes), 48_000):
        holes[begin : begin + 4800] = 0
    clean, broken = speech_quality(voice, [heard]), speech_quality(voice, [holes])
    assert clean is not None
    assert broken is not None
    assert clean > 4.9 > broken + 0.1
    assert speech_quality(voice, []) is None
