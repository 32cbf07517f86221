"""How a voice's readings are evaluated, and, briefly, the voice itself."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from e2e.delay.voice.command_age import Stretches, rows
from e2e.delay.voice.mouth_to_speaker import MOST_MS, PIECE_MS, delays, mouth_to_speaker
from e2e.delay.voice.silenced import muted, silent_after_ms
from e2e.measure.ear import BLOCK_MS, Block
from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from numpy.typing import NDArray


def loudness(seconds: float) -> NDArray[np.float64]:
    """Syllables of uneven length."""
    random = np.random.default_rng(5)
    smooth = np.convolve(random.normal(size=round(seconds * 1000)), np.hanning(80), "same")
    return np.asarray(0.01 + np.maximum(smooth, 0) * 0.02)


@pytest.mark.parametrize("late_ms", [0, 73, 400])
def test_the_delay_of_a_voice_is_found(late_ms: int) -> None:
    """It is found to the ms, whatever it is and however much quieter the speaker plays."""
    mouth = loudness(20)
    speaker = np.concatenate((np.zeros(late_ms), mouth))[: len(mouth)] * 0.3
    found = delays(mouth, speaker)
    assert len(found) > 30
    assert set(found) == {float(late_ms)}


def test_what_was_not_played_has_no_delay() -> None:
    """Another sound is not mistaken for the words, and silence is not judged."""
    mouth = loudness(20)
    speaker = mouth.copy()
    speaker[5000 : 5000 + PIECE_MS + MOST_MS] = 0
    mouth[10_000 : 10_000 + PIECE_MS] = 0
    found = delays(mouth, speaker)
    assert found[10] is None
    assert len(found) == len(range(0, 20_000 - PIECE_MS - MOST_MS, PIECE_MS)) - 1


def blocks(until_ms: float, *, of_ms: float = 3000) -> list[Block]:
    starts = np.arange(0, of_ms, BLOCK_MS)
    return [Block(at, 0.1 if at < until_ms else 0.0, 0, 0) for at in map(float, starts)]


@pytest.mark.parametrize(("until_ms", "late_ms"), [(1500, 0), (1620, 120), (2900, None)])
def test_silence_begins_after_the_last_sound(until_ms: float, late_ms: float | None) -> None:
    """What still sounds after a second was not silenced."""
    assert silent_after_ms(blocks(until_ms), 1500) == late_ms


@pytest.mark.parametrize("heard", [blocks(1400), blocks(1620, of_ms=2000)])
def test_a_pause_is_not_taken_for_silence(heard: list[Block]) -> None:
    """Neither a pause nor a stretch that was not recorded counts as silence."""
    with pytest.raises(MeasureError):
        silent_after_ms(heard, 1500)


def test_a_voice_that_delays_commands_misses_the_goal() -> None:
    """The quantiles are compared, and one command refused because of the voice misses the goal."""
    silent = Stretches([float(ms) for ms in range(100)], accepted=1000)
    ages_ms = [ms + 3.0 for ms in silent.ages_ms]
    (age,) = rows("lan", 2.0, silent, Stretches(ages_ms, 1000, 0, [True, False]))
    assert age.values == {"median": 3.0, "p95": 3.0, "p99": 3.0, "max": 3.0}
    assert age.met is False
    assert rows("lan", 3.0, silent, Stretches(ages_ms, 1000))[0].met is True
    assert rows("lan", 3.0, silent, Stretches(ages_ms, 1000, 2))[0].met is False
    with pytest.raises(MeasureError):
        rows("lan", 3.0, Stretches(), silent)


@pytest.mark.timeout(180)
async def test_words_are_found_at_the_robots_speaker() -> None:
    """Each half second of words arrives later than it was spoken."""
    (row,) = await mouth_to_speaker("same-machine", MOST_MS, 8)
    assert (row.n, row.met) == (8, True)
    assert row.spread is not None
    assert row.spread.min > 0


@pytest.mark.timeout(180)
async def test_the_host_silences_a_voice() -> None:
    """The voice sounds until the host mutes it, and then no more."""
    (row,) = await muted(300.0, 3)
    assert (row.n, row.met) == (3, True)
