"""``python -m e2e.lab.compare A.json B.json``: what moved between two runs, and whether it counts.

A difference counts where it is larger than the spread (the wider of the two runs' ranges from
least to greatest over their repetitions) and larger than what the instrument can tell apart.
Without repetitions there is no spread; then 10 % of A's figure stands in for it.

Exit status: 0 whatever moved, 2 with one sentence when a file is not a run.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from e2e.lab.report import goal_measures, pick, recovery
from e2e.lab.report.load import RunFileError, load
from e2e.lab.report.measures import MEASURES
from e2e.lab.report.shown import SAME_MS, SAME_SHARE, Spread, spread

if TYPE_CHECKING:
    from e2e.lab.report.measure import Measure, Unit
    from e2e.lab.report.pick import Entries
    from e2e.lab.results import Run

LEAST: Final[dict[Unit, float]] = {
    "ms": SAME_MS,
    "signed ms": SAME_MS,
    "per s": 0.2,
    "per min": 5.0,
    "s": 1.0,
    "share": 0.01,
    "bytes/s": 100.0,
    "signed ms/min": 20.0,
    "MiB": 1.0,
    "1": 0.05,
}
"""What is not told apart at all: 5 ms is the instrument's own error; 5 a minute is one pause in a
cell of 12 s, 20 ms a minute is 5 ms in a cell of 15 s."""
SHOWN: Final = 40
"""That many rows are for a person; all are in the JSON."""
ALL: Final = {**MEASURES, **recovery.MEASURES, **goal_measures.MEASURES}


@dataclass(frozen=True, slots=True)
class Moved:
    """One figure of one variant in both runs; `beyond` above 1 means that the difference counts."""

    variant: str
    figure: str
    a: Spread
    b: Spread
    difference: float
    limit: float
    limit_is: str
    beyond: float


@dataclass(frozen=True, slots=True)
class Comparison:
    """`only_a` and `only_b` are variants that the other run does not have."""

    moved: list[Moved]
    only_a: list[str]
    only_b: list[str]
    remarks: list[str]


def compare(a: Run, b: Run) -> Comparison:
    """Put the runs side by side, what moved farthest beyond its limit first."""
    cells_a, cells_b = _by_variant(a), _by_variant(b)
    moved = [
        found
        for variant in cells_a
        if variant in cells_b
        for measure in ALL.values()
        if (found := _moved(variant, measure, cells_a[variant], cells_b[variant]))
    ]
    return Comparison(
        moved=sorted(moved, key=lambda one: (-one.beyond, one.variant, one.figure)),
        only_a=[variant for variant in cells_a if variant not in cells_b],
        only_b=[variant for variant in cells_b if variant not in cells_a],
        remarks=[*_machines(a, b), *_statuses(cells_a, cells_b), *_figures(cells_a, cells_b)],
    )


def to_text(found: Comparison, a: str, b: str) -> str:
    """Write the short table for a person."""
    beyond = [one for one in found.moved if one.beyond > 1]
    lines = [f"A {a}", f"B {b}", *found.remarks, ""]
    if beyond:
        lines.append(f"{'variant':<44}{'figure':<24}{'A':>20}{'B':>20}{'B − A':>11}  limit")
        lines += [_line(one) for one in beyond[:SHOWN]]
        if len(beyond) > SHOWN:
            lines.append(f"… and {len(beyond) - SHOWN} more; --json has them all.")
    total = f"of {len(found.moved)} figures that both runs have"
    lines += ["", f"{len(beyond) or 'None'} {total} moved by more than the limit."]
    if any(one.limit_is != "spread" for one in beyond[:SHOWN]):
        lines.append(
            "* no repetitions, so there is no spread: against 10 % of A; + that, or the spread, is "
            "less than what the instrument tells apart: against the latter."
        )
    for name, variants in (("A", found.only_a), ("B", found.only_b)):
        if variants:
            lines.append(f"Only in {name}: {', '.join(variants)}")
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m e2e.lab.compare", description="Tell what moved between two runs of the lab."
    )
    parser.add_argument("a", type=Path, metavar="A.json", help="the run before")
    parser.add_argument("b", type=Path, metavar="B.json", help="the run after")
    parser.add_argument("--json", action="store_true", help="everything, for machines")
    given = parser.parse_args(arguments)
    try:
        found = compare(load(given.a), load(given.b))
    except RunFileError as error:
        print(error, file=sys.stderr)
        return 2
    if given.json:
        print(json.dumps(asdict(found), indent=2, ensure_ascii=False))
    else:
        print(to_text(found, str(given.a), str(given.b)))
    return 0


def _by_variant(run: Run) -> dict[str, Entries]:
    found: dict[str, Entries] = {}
    for entry in pick.entries(run):
        found[entry.cell.variant] = (*found.get(entry.cell.variant, ()), entry)
    return found


def _moved(variant: str, measure: Measure, cells_a: Entries, cells_b: Entries) -> Moved | None:
    a, b = spread(cells_a, measure), spread(cells_b, measure)
    if a is None or b is None:
        return None
    difference = b.median - a.median
    if max(a.n, b.n) > 1:
        limit, limit_is = max(a.most - a.least, b.most - b.least), "spread"
    else:
        limit, limit_is = SAME_SHARE * abs(a.median), "10 %"
    if limit < LEAST[measure.unit]:
        limit, limit_is = LEAST[measure.unit], "instrument"
    return Moved(variant, measure.name, a, b, difference, limit, limit_is, abs(difference) / limit)


def _machines(a: Run, b: Run) -> list[str]:
    """Say what differs between the machines, and between the commits."""
    keys = [key for key in {**a.machine, **b.machine} if key != "load_1min_before"]
    different = [key for key in keys if a.machine.get(key) != b.machine.get(key)]
    if not different:
        return []
    parts = [
        f"{key.replace('_', ' ')} {_short(a.machine.get(key), b.machine.get(key))} → "
        f"{_short(b.machine.get(key), a.machine.get(key))}"
        for key in different
    ]
    hardware = any(key in ("cpu", "cores", "memory_mib", "system") for key in different)
    start = "Different machines: absolute times do not compare. " if hardware else ""
    return [f"{start}Different: {'; '.join(parts)}."]


def _short(value: Any, other: Any) -> str:
    if isinstance(value, dict) and isinstance(other, dict):
        differing = {key: one for key, one in value.items() if other.get(key) != one}
        return ", ".join(f"{key} {one}" for key, one in differing.items()) or "–"
    return "–" if value is None else str(value)


def _statuses(cells_a: dict[str, Entries], cells_b: dict[str, Entries]) -> list[str]:
    """Say which variants are ok in one run and not in the other."""
    found = []
    for variant, entries in cells_a.items():
        before = Counter(entry.result.status for entry in entries)
        after = Counter(entry.result.status for entry in cells_b.get(variant, entries))
        if bool(before["ok"]) != bool(after["ok"]):
            gone, cells = (
                ("ok in A, in B", cells_b[variant]) if before["ok"] else ("ok in B, in A", entries)
            )
            found.append(f"{variant}: {gone} {cells[0].result.status}: {cells[0].problem}")
    return found


def _figures(cells_a: dict[str, Entries], cells_b: dict[str, Entries]) -> list[str]:
    """Say which figures one run has of a variant and the other, though it is ok there, has not."""
    found = []
    for variant, entries in cells_a.items():
        both = (entries, cells_b.get(variant, ()))
        if not all(any(one.result.status == "ok" for one in cells) for cells in both):
            continue
        has_a, has_b = (
            [measure.label for measure in ALL.values() if spread(cells, measure)] for cells in both
        )
        for name, has, other in (("A", has_a, has_b), ("B", has_b, has_a)):
            lone = [label for label in has if label not in other]
            if lone:
                found.append(f"{variant}: only {name} has {'; '.join(lone)}")
    return found


def _line(one: Moved) -> str:
    measure = ALL[one.figure]
    mark = {"spread": "", "10 %": " *", "instrument": " +"}[one.limit_is]
    sign = "+" if one.difference > 0 and not measure.text(one.difference).startswith("+") else ""
    return (
        f"{one.variant:<44}{measure.label:<24}{_range(measure, one.a):>20}"
        f"{_range(measure, one.b):>20}{sign + measure.text(one.difference):>11}  "
        f"{measure.with_unit(one.limit).lstrip('+')}{mark}"
    )


def _range(measure: Measure, summed: Spread) -> str:
    text = measure.text(summed.median)
    if summed.n > 1:
        text += f" ({measure.text(summed.least)}…{measure.text(summed.most)})"
    return text


if __name__ == "__main__":
    sys.exit(main())
