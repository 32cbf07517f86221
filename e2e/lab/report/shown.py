"""From cells of the run to one cell of a table: median, spread, and the keys behind it."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING, Final

from e2e.lab.report.blocks import Line, Shown

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.lab.report.blocks import Entry
    from e2e.lab.report.measure import Measure
    from e2e.lab.report.thesis import Said

SAME_MS: Final = 5.0
"""The instrument's own error."""
SAME_SHARE: Final = 0.1
"""What one repetition is trusted for where there are no others."""
NOTHING = Shown("nothing", (Line("–", "There is no such cell in this run."),))


@dataclass(frozen=True, slots=True)
class Spread:
    """The median over the repetitions, with the least and the greatest."""

    median: float
    least: float
    most: float
    n: int


def spread(entries: Sequence[Entry], measure: Measure) -> Spread | None:
    """Sum up what was measured; None where nothing was."""
    values = [value for entry in entries if (value := measure.of(entry.result)) is not None]
    if not values:
        return None
    return Spread(median(values), min(values), max(values), len(values))


def alike(one_ms: float, other_ms: float) -> bool:
    """Whether two times are not to be told apart: within 5 ms or 10 % of the lesser."""
    within_ms = max(SAME_MS, SAME_SHARE * min(abs(one_ms), abs(other_ms)))
    return abs(one_ms - other_ms) <= within_ms


def said(what: Said | None) -> Shown:
    """Show the thesis's words, or that it has none."""
    if what is None:
        return Shown("nothing", (Line("–", "The thesis does not say."),))
    return Shown("said", (Line(what.text, what.where),))


def figure(entries: Sequence[Entry], measure: Measure, *, prefix: str = "") -> Line:
    """Write the median with its spread; on hover each key and its own number."""
    summed = spread(entries, measure)
    title = "; ".join(f"{entry.key}: {_one(entry, measure)}" for entry in entries)
    anchor = entries[0].anchor if entries else None
    if summed is None:
        return Line(f"{prefix}–", title, anchor)
    text = prefix + measure.text(summed.median)
    least, most = measure.text(summed.least), measure.text(summed.most)
    if least == most:
        return Line(text, title, anchor)
    # A dash between signed numbers could be read as a minus.
    dash = "…" if measure.unit.startswith("signed") or "−" in least + most else "–"
    return Line(text, title, anchor, spread=f"({least}{dash}{most})")


def cell(entries: Sequence[Entry], *measures: Measure, prefixes: Sequence[str] = ()) -> Shown:
    """Show each measure on a line, then what failed or was not run, with its sentence."""
    whole = problem(entries)
    if whole is not None:
        return whole
    starts = [*prefixes, *([""] * (len(measures) - len(prefixes)))]
    lines = [
        figure(entries, measure, prefix=prefix)
        for measure, prefix in zip(measures, starts, strict=True)
    ]
    return Shown("ok", (*lines, *partly(entries)))


def problem(entries: Sequence[Entry]) -> Shown | None:
    """Show why there is no figure at all; None where at least one of the cells is ok."""
    if not entries:
        return NOTHING
    if any(entry.result.status == "ok" for entry in entries):
        return None
    failed = [entry for entry in entries if entry.result.status == "failed"]
    first = (failed or list(entries))[0]
    return Shown(
        "failed" if failed else "not run",
        (
            Line(
                f"{first.result.status}: {first.problem}",
                "; ".join(f"{entry.key}: {entry.problem}" for entry in entries),
                first.anchor,
            ),
        ),
    )


def partly(entries: Sequence[Entry]) -> tuple[Line, ...]:
    """Name the repetitions that are missing beside those that are ok."""
    return tuple(
        Line(
            f"{entry.result.status} once: {entry.problem}",
            f"{entry.key}: {entry.problem}",
            entry.anchor,
            small=True,
            is_problem=True,
        )
        for entry in entries
        if entry.result.status != "ok"
    )


def _one(entry: Entry, measure: Measure) -> str:
    if entry.result.status != "ok":
        return f"{entry.result.status}, {entry.problem}"
    value = measure.of(entry.result)
    return "nothing measured" if value is None else measure.with_unit(value)
