"""The score for speech: it recognises its own words through noise and a gap, and no others."""

from __future__ import annotations

import numpy as np
from e2e.harness.speech import RATE_HZ, in_order, voice

WORDS = voice(12.0)
LOOPED = np.tile(WORDS, 2)[int(10.3 * RATE_HZ) :][: 4 * RATE_HZ]
"""Four seconds across the end of the loop."""


def test_words_are_known_through_noise_at_half_their_level() -> None:
    noise = np.random.default_rng(2004).normal(0, 0.5 * WORDS.std(), len(LOOPED))
    assert in_order((LOOPED / 4 + noise / 4).astype(np.int16), WORDS) == 1


def test_a_gap_costs_its_own_half_second() -> None:
    cut = np.delete(LOOPED, slice(RATE_HZ, int(1.2 * RATE_HZ)))
    assert 0.5 <= in_order(cut, WORDS) < 1


def test_other_words_and_silence_are_not_in_order() -> None:
    assert in_order(LOOPED[::-1], WORDS) < 0.3
    assert in_order(np.zeros_like(LOOPED), WORDS) == 0
