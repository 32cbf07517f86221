"""The audio probe's arithmetic: loudness, and the start of the test card's bursts (pure)."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.measure.ear import Block

BLOCK_MS = 10.0


def loudness(blocks: Sequence[Block]) -> float:
    """Root mean square over all blocks, 0…1; 0 of nothing."""
    if not blocks:
        return 0.0
    return float((sum(block.rms**2 for block in blocks) / len(blocks)) ** 0.5)


def burst_ages_ms(blocks: Sequence[Block]) -> list[float]:
    """How long after its whole second each 1 kHz burst was heard, 0…1000 ms.

    The first block holds a part of the burst; how much of it tells the time inside the block.
    """
    ages: list[float] = []
    for before, first, second in zip(blocks, blocks[1:], blocks[2:], strict=False):
        if before.burst < 0.02 <= first.burst and second.burst > 0.1:
            share = min(1.0, first.burst / second.burst)
            onset_ms = first.start_ms + BLOCK_MS * (1 - share)
            ages.append(onset_ms % 1000)
    return ages


def gaps_ms(blocks: Sequence[Block]) -> list[float]:
    """Return the pauses in the quiet 300 Hz tone, which has none at its source."""
    gaps: list[float] = []
    silent = 0
    for block in blocks:
        if block.tone < 0.01 and block.burst < 0.01:
            silent += 1
        elif silent:
            gaps.append(silent * BLOCK_MS)
            silent = 0
    return gaps
