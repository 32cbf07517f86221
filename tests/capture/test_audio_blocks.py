"""Blocks: no sample lost, none made up, and an even timeline."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.capture.audio_blocks import Blocks
from wax.capture.source import BLOCK_SAMPLES, Sound


def sound(count: int, captured_s: float, first: int = 0) -> Sound:
    """Make numbered samples, so that order and loss can be seen."""
    return Sound(((first + np.arange(count)) % 30_000 + 1).astype(np.int16), captured_s)


def push_all(blocks: Blocks, pieces: list[Sound]) -> list[Sound]:
    return [block for piece in pieces for block in blocks.push(piece)]


@given(
    lengths=st.lists(st.integers(1, 3000), min_size=1, max_size=60),
    jitter=st.lists(st.floats(-0.04, 0.04), min_size=60, max_size=60),
    start_s=st.floats(0, 1e7),
)
def test_jitter_loses_and_makes_no_sample(
    lengths: list[int], jitter: list[float], start_s: float
) -> None:
    """Pieces of any length come out in order as blocks that are 10 ms apart ± 0.1 ms."""
    blocks = Blocks()
    pieces, first = [], 0
    for length, offset_s in zip(lengths, jitter, strict=False):
        pieces.append(sound(length, start_s + first / 48000 + offset_s, first))
        first += length
    out = push_all(blocks, pieces)
    assert len(out) == first // BLOCK_SAMPLES
    assert all(len(block.samples) == BLOCK_SAMPLES for block in out)
    if out:
        joined = np.concatenate([block.samples for block in out])
        assert np.array_equal(joined, np.concatenate([p.samples for p in pieces])[: len(joined)])
        # A block may span two pieces that are longer than it, each of which corrects in full.
        steps = np.diff([block.captured_s for block in out])
        assert np.abs(steps - 0.01).max(initial=0) <= 0.0001 + 1e-6
    assert blocks.filled_samples == blocks.dropped_samples == 0


@given(jitter=st.lists(st.floats(-0.03, 0.03), min_size=300, max_size=300))
@examples(30)
def test_times_are_much_evener_than_the_device(jitter: list[float]) -> None:
    """For pieces with jittering times, each block is 10 ms after the last ± 0.05 ms."""
    blocks = Blocks()
    pieces = [sound(960, 5 + index * 0.02 + late_s) for index, late_s in enumerate(jitter)]
    times = [block.captured_s for block in push_all(blocks, pieces)]
    assert np.abs(np.diff(times) - 0.01).max() <= 0.00005 + 1e-9


@pytest.mark.parametrize("ppm", [-300, 300])
def test_a_drifting_sound_card_is_followed(ppm: int) -> None:
    """After two minutes on a card that is 300 ppm off, block times are within 5 ms of the truth."""
    blocks = Blocks()
    samples, last, truth_s = sound(960, 0.0).samples, None, 0.0
    for index in range(6_000):
        truth_s = 10 + index * 0.02 * (1 + ppm / 1e6)
        for block in blocks.push(Sound(samples, truth_s)):
            last = block
    assert last is not None
    assert last.captured_s + 0.01 == pytest.approx(truth_s + 0.02, abs=0.005)
    assert blocks.filled_samples == blocks.dropped_samples == 0


@given(
    pieces=st.lists(
        st.tuples(st.integers(1, 1500), st.sampled_from([1, 2])), min_size=1, max_size=40
    )
)
def test_one_channel_or_two(pieces: list[tuple[int, int]]) -> None:
    """When the number of channels changes, no sample is lost, and each block has one shape."""
    blocks, out, first = Blocks(), [], 0
    for length, channels in pieces:
        piece = sound(length, 1.0 + first / 48000, first)
        out += blocks.push(piece.with_channels(channels))
        first += length
    assert {block.samples.shape for block in out} <= {(480,), (480, 2)}
    left = [block.samples if block.channels == 1 else block.samples[:, 0] for block in out]
    numbered = (np.arange(len(out) * 480) % 30_000) + 1
    assert np.array_equal(np.concatenate([np.zeros(0, np.int16), *left]), numbered)


def test_a_gap_in_stereo_is_silent_in_both_ears() -> None:
    """The silence that fills a gap has the shape of the sound around it."""
    pieces = [sound(960, at_s).with_channels(2) for at_s in (1.0, 1.32)]
    out = push_all(Blocks(), pieces)
    assert {block.samples.shape for block in out} == {(480, 2)}
    joined = np.concatenate([block.samples for block in out])
    assert (joined[960 : 960 + 14_400] == 0).all()
    assert (joined[960 + 14_400 :] != 0).all()


@given(gap_s=st.floats(0.101, 0.99))
def test_a_gap_is_filled_with_silence(gap_s: float) -> None:
    """Sound after a gap of up to 1 s keeps its own time, and the gap is silence."""
    blocks = Blocks()
    out = push_all(blocks, [sound(960, 1.0), sound(960, 1.02 + gap_s), sound(960, 1.04 + gap_s)])
    joined = np.concatenate([block.samples for block in out])
    silent = np.flatnonzero(joined == 0)
    assert len(silent) == blocks.filled_samples == round(gap_s * 48000)
    assert blocks.filled_ms == pytest.approx(gap_s * 1000, abs=1)
    assert blocks.dropped_ms == 0
    assert np.array_equal(silent, 960 + np.arange(len(silent)))
    assert np.diff([block.captured_s for block in out]) == pytest.approx(0.01, abs=1e-6)


def test_a_restart_fills_no_gap() -> None:
    """After a restart the timeline begins with the next piece, and a part of a block is dropped."""
    blocks = Blocks()
    blocks.push(sound(1000, 1.0))
    blocks.restart()
    (block,) = blocks.push(sound(480, 1.5))
    assert (block.captured_s, block.samples[0]) == (1.5, 1)
    assert (blocks.filled_samples, blocks.dropped_samples) == (0, 40)


@given(back_s=st.floats(0.101, 0.99))
def test_an_overlap_is_left_out(back_s: float) -> None:
    """Sound that overlaps what was delivered is dropped: times rise and no delay is added."""
    blocks = Blocks()
    pieces = [sound(960, 1 + index * 0.02) for index in range(60)]
    pieces += [sound(960, 2.2 - back_s + index * 0.02) for index in range(60)]
    out = push_all(blocks, pieces)
    assert blocks.dropped_samples == pytest.approx(back_s * 48000, abs=0.1 * 48000 + 1)
    assert blocks.dropped_ms == blocks.dropped_samples // 48
    assert blocks.filled_ms == 0
    assert np.diff([block.captured_s for block in out]) == pytest.approx(0.01, abs=0.00006)
    end_s = 2.2 - back_s + 60 * 0.02
    assert out[-1].captured_s + 0.01 == pytest.approx(end_s, abs=0.1 + 0.01)


@pytest.mark.parametrize("jump_s", [-3600.0, -1.5, 1.5, 3600.0])
def test_a_jump_starts_the_time_line_anew(jump_s: float) -> None:
    """After a jump of more than 1 s the next block has the new time, and nothing is filled."""
    blocks = Blocks()
    before = blocks.push(sound(1000, 5000.0))
    after = blocks.push(sound(960, 5000.0 + 1000 / 48000 + jump_s))
    assert [len(before), len(after)] == [2, 2]
    assert after[0].captured_s == pytest.approx(5000.0 + 1000 / 48000 + jump_s)
    assert after[0].samples[0] == 1
    assert blocks.filled_samples == 0
    assert blocks.dropped_samples == 40
