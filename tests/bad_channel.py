"""Traces over an untrusted channel: the errors of IEC 61784-3, and their outcomes."""

from __future__ import annotations

import os
import random
from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, Protocol

from tests.examples import share_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    Cell = tuple[str, str]

ERRORS: Final = (
    "corruption",
    "repetition",
    "wrong order",
    "loss",
    "delay",
    "insertion",
    "masquerade",
)


@dataclass
class Tally:
    """The outcomes of all traces."""

    traces: int = 1
    wrong: list[str] = field(default_factory=list)
    injected: Counter[Cell] = field(default_factory=Counter)
    happened: Counter[str] = field(default_factory=Counter)


class Trace(Protocol):
    def run(self) -> str | None:
        """Return what was wrong, if anything."""


def run(
    cells: Sequence[Cell], trace: Callable[[random.Random, Cell, Tally], Trace], of: int, seed: int
) -> Tally:
    """Run `of` traces, the cells in turn; check that none is wrong, and that each error occurred.

    The same seed makes the same traces; ``WAX_TRACES`` sets another number.
    """
    tally = Tally(int(os.environ.get("WAX_TRACES", share_of(of))))
    for number in range(tally.traces):
        cell = cells[number % len(cells)]
        fault = trace(random.Random(f"{seed}/{number}"), cell, tally).run()
        if fault is not None:
            tally.wrong.append(f"trace {number} of seed {seed}, {cell}: {fault}")
    assert tally.wrong == []
    assert all(tally.injected[cell] >= tally.traces // 50 for cell in cells)
    return tally
