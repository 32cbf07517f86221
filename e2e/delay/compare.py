"""``python -m e2e.delay.compare A B``: what moved between two runs, and whether it counts.

A and B are ``results.jsonl`` of a suite of the lab; of each its newest product counts. A difference
counts where it is larger than the spread (the wider of the two runs' ranges from least to greatest
over their repetitions) and larger than what the instrument can tell apart. Without repetitions
there is no spread; then 10 % of A's figure stands in for it.

Exit status: 0 whatever moved, 2 with one sentence when a file holds no results.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from e2e.delay.found import found, spread
from e2e.delay.measures import MEASURES
from e2e.delay.report.experiments import SAME_MS, SAME_SHARE
from e2e.delay.report.page import newest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.delay.found import Found
    from e2e.delay.measures import Unit
    from e2e.measure.results import Result
    from e2e.measure.summary import Summary

LEAST: Final[dict[Unit, float]] = {
    "ms": SAME_MS,
    "±ms": SAME_MS,
    "/s": 0.2,
    "/min": 5.0,
    "s": 1.0,
    "%": 1.0,
    "kB/s": 0.1,
    "±ms/min": 20.0,
    "MiB": 1.0,
    "": 0.05,
}
"""What is not told apart at all: 5 ms is the instrument's own error; 5 a minute is one pause in a
cell of 12 s, 20 ms a minute is 5 ms in a cell of 15 s."""


@dataclass(frozen=True, slots=True)
class Moved:
    """One figure of one variant in both runs; `beyond` above 1 means that the difference counts."""

    variant: str
    figure: str
    a: Summary
    b: Summary
    beyond: float

    def __str__(self) -> str:
        measure = MEASURES[self.figure]
        texts = [
            measure.with_unit(one.median)
            + (f" ({measure.text(one.min)}…{measure.text(one.max)})" if one.n > 1 else "")
            for one in (self.a, self.b)
        ]
        return f"{self.variant:<44}{measure.label:<30}{texts[0]:>24} → {texts[1]}"


def compare(a: Sequence[Result], b: Sequence[Result]) -> tuple[list[Moved], list[str]]:
    """Put the runs side by side, what moved farthest beyond its limit first; and what is odd."""
    cells_a, cells_b = _by_variant(a), _by_variant(b)
    moved, odd = [], _origins(a, b)
    for variant in dict.fromkeys((*cells_a, *cells_b)):
        both = cells_a.get(variant, []), cells_b.get(variant, [])
        for measure in MEASURES.values():
            in_a, in_b = (spread(cells, measure.name) for cells in both)
            if in_a is not None and in_b is not None:
                more = abs(in_b.median - in_a.median)
                beyond = more / max(_limit(in_a, in_b), LEAST[measure.unit])
                moved.append(Moved(variant, measure.name, in_a, in_b, beyond))
            elif (in_a or in_b) and all(both):
                odd.append(f"{variant}: only {'A' if in_a else 'B'} has {measure.label}")
        if not all(both):
            odd.append(f"only {'A' if both[0] else 'B'} has {variant}")
    return sorted(moved, key=lambda one: (-one.beyond, one.variant, one.figure)), odd


def _limit(a: Summary, b: Summary) -> float:
    if max(a.n, b.n) > 1:
        return max(a.max - a.min, b.max - b.min)
    return SAME_SHARE * abs(a.median)


def _by_variant(results: Sequence[Result]) -> dict[str, list[Found]]:
    cells: dict[str, list[Found]] = {}
    for one in found(row for result in results for row in result.rows):
        cells.setdefault(one.cell.variant, []).append(one)
    return cells


def _origins(a: Sequence[Result], b: Sequence[Result]) -> list[str]:
    """Say what differs between the machines, and between the commits."""
    first, second = a[-1].origin, b[-1].origin
    said = [f"commits {first.commit} → {second.commit}"]
    if first.machine != second.machine:
        said.append(
            f"different machines, so absolute times do not compare: {first.machine} → "
            f"{second.machine}"
        )
    return said


def main(words: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m e2e.delay.compare",
        description="Tell what moved between two runs.",
    )
    parser.add_argument("runs", type=Path, nargs=2, metavar="results.jsonl", help="before, after")
    before, after = parser.parse_args(words).runs
    runs = []
    for path in (before, after):
        results = newest(path.parent) if path.is_file() else []
        if not results:
            print(f"{path} holds no results; name a suite's results.jsonl", file=sys.stderr)
            return 2
        runs.append(results)
    moved, odd = compare(*runs)
    beyond = [one for one in moved if one.beyond > 1]
    print("\n".join([*odd, *map(str, beyond)]))
    print(f"{len(beyond)} of {len(moved)} figures that both have moved by more than the limit.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
