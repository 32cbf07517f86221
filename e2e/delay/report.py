"""``python -m e2e.delay.report``: all results of a suite, link by link, as text.

Each system's figures are next to what the thesis says of that link.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from e2e.delay.judging import found
from e2e.delay.measures import MEASURES
from e2e.delay.names import AGE, ARRIVAL, GIVEN, LINKS, SHARPNESS, SYSTEMS, profile, shown
from e2e.delay.thesis import words
from e2e.measure.command import OUT
from e2e.measure.results import Results
from e2e.measure.row import summarize
from e2e.measure.table import number

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from e2e.delay.cell import Cell
    from e2e.delay.judging import Found
    from e2e.measure.results import Result


def lines(results: Sequence[Result]) -> Iterator[str]:
    """Yield what was found, and what failed, for the newest product."""
    cells = found(row for result in results for row in result.rows)
    if results:
        yield f"Commit {results[-1].origin.commit}, {results[-1].origin.machine}."
    yield from (
        AGE,
        SHARPNESS,
        ARRIVAL,
        *GIVEN,
        *(f"{one.case}: {one.problem}" for one in results if one.problem),
    )
    names = {one.cell.profile for one in cells}
    for name in sorted(names, key=lambda one: (*LINKS, one).index(one)):
        yield f"\n{shown(name)}: {profile(name).about}"
        yield from _link(name, [one for one in cells if one.cell.profile == name])


def _link(name: str, cells: Sequence[Found]) -> Iterator[str]:
    for mu_ms in sorted({one.cell.audio_mu_ms or 500 for one in cells}):
        said = words(name, mu_ms)
        told = [f"{_head(one)}: {of.text} ({of.where})" for one, of in said.items()]
        yield from ["; ".join([f"* thesis, {mu_ms} ms", *told])] if said else []
    groups: dict[str, list[Found]] = {}
    for one in sorted(cells, key=lambda one: list(SYSTEMS).index(one.cell.system)):
        groups.setdefault(one.cell.variant, []).append(one)
    for here in groups.values():
        told = [f"{_head(one)}: {value}" for one in MEASURES if (value := _value(one, here))]
        yield "; ".join([f"* {_who(here[0].cell)} (n {len(here)})", *told])


def _head(measure: str) -> str:
    return ", ".join(filter(None, MEASURES[measure]))


def _who(cell: Cell) -> str:
    but = (shown(cell.profile), cell.system)
    more = " ".join(part for part in cell.variant.split("/") if part not in but)
    return f"{SYSTEMS[cell.system]} {more}".strip()


def _value(measure: str, cells: Sequence[Found]) -> str:
    """Return the median, and each repetition's number if there are several; "" for none."""
    tried = [one.values[measure] for one in cells if measure in one.values]
    known = [value for value in tried if value is not None]
    if not tried:
        return ""
    often = 2 * len(known) >= len(tried) and known
    each = ", ".join("never" if one is None else number(one) for one in tried)
    median = number(summarize(known).median) if often else "never"
    return f"{median} ({each})" if len(tried) > 1 else median


if __name__ == "__main__":
    print(*lines(Results(OUT / "delay").newest()), sep="\n")
