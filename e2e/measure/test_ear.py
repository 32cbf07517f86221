"""The ear: each block's time, and that it hears what is played."""

from __future__ import annotations

import asyncio
import os
import random

import numpy as np
import pytest

from e2e.measure.ear import BLOCK, RATE_HZ, Ear, Pace, open_ear


def test_uneven_arrivals_are_an_even_row() -> None:
    """Blocks that come up to 8 ms late have the times at which they were played."""
    noise, pace = random.Random(1), Pace()
    begins = [
        pace.at_ms(1000 + 10 * (number + 1) + noise.uniform(0, 8)) - 1000 - 10 * number
        for number in range(500)
    ]
    assert all(-0.01 <= off < 1.0 for off in begins[200:])


def test_a_pause_begins_another_row() -> None:
    """After half a second without samples the next block has its arrival's time."""
    pace = Pace()
    for number in range(100):
        pace.at_ms(10.0 * (number + 1))
    assert pace.at_ms(1500.0) == 1490.0


@pytest.mark.parametrize("bytes_at_once", [4, 100, 8 * BLOCK, 9999])
def test_pieces_of_any_size_are_the_same_blocks(bytes_at_once: int) -> None:
    """However the samples are cut, each 10 ms are one block with the right tones."""
    at = np.arange(10 * BLOCK) / RATE_HZ
    tone = np.sin(2 * np.pi * 300 * at)
    data = np.column_stack((0.8 * tone, 0.2 * tone)).astype(np.float32).tobytes()
    ear = Ear({})
    tap = ear.tap(records=True)
    for begin in range(0, len(data), bytes_at_once):
        piece = data[begin : begin + bytes_at_once]
        ear.hear(piece, 1000 + (begin + len(piece)) / (8 * RATE_HZ) * 1000)
    heard = tap.take()
    assert len(heard) == 10
    recorded = np.concatenate(tap.recorded or [])
    assert recorded.max(axis=0) == pytest.approx([0.8, 0.2], abs=0.01)
    assert [one.tone for one in heard] == pytest.approx([0.5] * 10, abs=0.01)
    assert max(one.burst for one in heard) < 0.01
    starts = [one.start_ms for one in heard]
    assert np.diff(starts) == pytest.approx([10.0] * 9, abs=0.1)
    assert tap.first_ms == starts[0]
    assert tap.take() == []


@pytest.mark.full
async def test_what_is_played_is_heard() -> None:
    """A tone that another program plays on the device is heard, and so is its end."""
    async with open_ear() as ear:
        tap = ear.tap()
        assert not await tap.hears(within_s=0.5)
        player = await asyncio.create_subprocess_exec(
            *("pacat", "--raw", "--format=float32le", f"--rate={RATE_HZ}", "--channels=1"),
            stdin=asyncio.subprocess.PIPE,
            env={**os.environ, **ear.variables},
        )
        at = np.arange(RATE_HZ) / RATE_HZ
        await player.communicate((0.5 * np.sin(2 * np.pi * 300 * at)).astype("<f4").tobytes())
        assert await tap.hears(within_s=5)
        assert sum(block.tone > 0.4 for block in tap.take()) >= 90
