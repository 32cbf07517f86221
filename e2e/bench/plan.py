"""How long and how often: the full run (under 15 minutes) and the quick one (under 2)."""

from __future__ import annotations

from dataclasses import dataclass

FPS = 30.0
SIZE = "640x480"


@dataclass(frozen=True, slots=True)
class Plan:
    """Durations and counts of one run.

    A fan-out point is `windows` windows of `window_s`, after `settle_s` of rest; their spread is
    the spread of the result. `joins` are page loads, `presses` key presses, `cycles` one viewer
    joining and leaving.
    """

    quick: bool
    our_viewers: tuple[int, ...]
    stock_viewers: tuple[int, ...]
    window_s: float
    windows: int
    settle_s: float
    joins: int
    presses: int
    our_memory_viewers: tuple[int, ...]
    stock_memory_viewers: tuple[int, ...]
    memory_settle_s: float
    cycles: int


FULL = Plan(
    quick=False,
    our_viewers=(1, 2, 4, 8, 16, 32, 50),
    stock_viewers=(1, 2, 4, 8),
    window_s=2.0,
    windows=6,
    settle_s=4.0,
    joins=20,
    presses=220,
    our_memory_viewers=(1, 2, 4, 8, 16),
    stock_memory_viewers=(1, 2, 4),
    memory_settle_s=4.0,
    cycles=200,
)

QUICK = Plan(
    quick=True,
    our_viewers=(1, 4, 16),
    stock_viewers=(1, 4, 8),
    window_s=1.0,
    windows=3,
    settle_s=1.5,
    joins=3,
    presses=15,
    our_memory_viewers=(1, 4),
    stock_memory_viewers=(1, 4),
    memory_settle_s=1.5,
    cycles=16,
)
