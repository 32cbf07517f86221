"""The probes' arithmetic: whether the test card is live, and how its sound is heard (pure)."""

from __future__ import annotations

from itertools import pairwise
from statistics import median
from typing import TYPE_CHECKING, Final

from e2e.measure.ear import BLOCK_MS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.harness.viewer import Card
    from e2e.measure.ear import Block

LIVE_MS: Final = 100.0
"""Median age on one machine, a few times the usual: 10 ms in Chromium, 25 in Firefox."""


def assert_live(cards: Sequence[Card], held_ms: float = 0.0) -> None:
    """Assert that nearly all frames are whole, in order, and live.

    `held_ms` is how long they are held back for their sound.
    """
    valid = [card for card in cards if card.valid]
    assert len(valid) >= 0.9 * len(cards), f"{len(cards) - len(valid)} unreadable of {len(cards)}"
    stamps = [card.stamp_ms for card in valid]
    # A page that is late for a frame reads the next one twice.
    assert all(a <= b for a, b in pairwise(stamps)), f"falling: {stamps}"
    assert len(set(stamps)) >= 0.9 * len(stamps), f"standing still: {stamps}"
    ages = [card.age_ms for card in valid]
    assert min(ages) >= 0, f"a picture from the future: {ages}"
    assert median(ages) < held_ms + LIVE_MS, f"old pictures: {ages}"


def loudness(blocks: Sequence[Block]) -> float:
    """Root mean square over all blocks, 0…1; 0 if there are none."""
    if not blocks:
        return 0.0
    return float((sum(block.rms**2 for block in blocks) / len(blocks)) ** 0.5)


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
