"""How late a voice is at the robot's speaker."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from e2e.delay.voice.stage import staged
from e2e.harness.page_clock import page_clock, unix_ms
from e2e.measure.ear import BLOCK, BLOCK_MS
from e2e.measure.errors import MeasureError
from e2e.measure.row import timed

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from e2e.measure.ear import Tap
    from e2e.measure.row import Row

    Piece = tuple[float, Sequence[float]]

PIECE_MS: Final = 500
MOST_MS: Final = 1000
"""A piece later than this counts as never played."""
_LOUD: Final = 0.01
"""A piece that is quieter than this on average does not show when it was played."""
_ALIKE: Final = 0.5
_SHARE: Final = 0.5
"""At least this share of the words is loud."""


async def mouth_to_speaker(profile: str, goal_ms: float, n: int) -> list[Row]:
    """Speak until `n` pieces of half a second can be judged."""
    async with staged(profile, listens=True) as stage:
        tap = stage.ear.tap(records=True)
        await stage.window.keyboard.down("KeyT")
        await asyncio.sleep((n / _SHARE * PIECE_MS + MOST_MS) / 1000)
        clock = await page_clock(stage.window.evaluate)
        # The microphone delivers each piece when it has recorded all of it.
        mouth = [
            (clock.monotonic_s(at_ms) * 1000 - len(loudness), loudness)
            for at_ms, loudness in (await stage.taken())["heard"]
        ]
        await stage.window.keyboard.up("KeyT")
    speaker = _played(tap)
    if not mouth or not speaker:
        raise MeasureError("nothing was said, or nothing played")
    begin_ms = min(at_ms for at_ms, _ in mouth)
    late_ms = delays(_row(mouth, begin_ms), _row(speaker, begin_ms))[:n]
    what = f"a voice, from the mouth to the robot’s speaker: {profile}"
    return [
        timed(
            f"mouth-to-speaker/{profile}",
            what,
            late_ms,
            goal_ms,
            judged="p95",
            clock_error_ms=clock.error_s * 1000,
        )
    ]


def delays(mouth: NDArray[np.float64], speaker: NDArray[np.float64]) -> list[float | None]:
    """Return how much later each loud piece of `mouth` was played, ms; None if it was not.

    Both arrays are the loudness of each ms from the same moment on.
    """
    found: list[float | None] = []
    for start in range(0, len(mouth) - PIECE_MS - MOST_MS, PIECE_MS):
        piece = mouth[start : start + PIECE_MS]
        if piece.mean() < _LOUD:
            continue
        heard = speaker[start : start + PIECE_MS + MOST_MS]
        if len(heard) < PIECE_MS + MOST_MS:
            break
        windows = sliding_window_view(heard, PIECE_MS)
        apart = windows - windows.mean(axis=1, keepdims=True)
        own = piece - piece.mean()
        fits = apart @ own / (np.linalg.norm(apart, axis=1) * np.linalg.norm(own) + 1e-9)
        best = int(np.argmax(fits))
        found.append(float(best) if fits[best] >= _ALIKE else None)
    return found


def _played(tap: Tap) -> list[Piece]:
    """Return what the ear recorded on the monotonic clock, as the loudness of each ms."""
    ahead_ms = unix_ms(0.0)
    per_ms = round(BLOCK / BLOCK_MS)
    recorded = [both.mean(axis=1).reshape(-1, per_ms) for both in tap.recorded or []]
    return [
        (block.start_ms - ahead_ms, np.sqrt((samples**2).mean(axis=1)))
        for block, samples in zip(tap.heard, recorded, strict=True)
    ]


def _row(pieces: Iterable[Piece], begin_ms: float) -> NDArray[np.float64]:
    """Place the loudness of each ms on a time line from `begin_ms` on."""
    placed = [(round(at_ms - begin_ms), loudness) for at_ms, loudness in pieces]
    row = np.zeros(max(at + len(loudness) for at, loudness in placed))
    for at, loudness in placed:
        if at >= 0:
            row[at : at + len(loudness)] = loudness
    return row
