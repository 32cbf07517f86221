"""Formats rows for the terminal, and as a table of Markdown."""

from __future__ import annotations

from collections import Counter
from textwrap import fill
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.measure.published import Published
    from e2e.measure.row import Row


def to_table(rows: Sequence[Row]) -> str:
    """Set rows as lines for the terminal, with what explains them."""
    lines = []
    for row in rows:
        values = "  ".join(f"{name} {number(value)}" for name, value in row.values.items())
        goal = f"{row.judged} {_goal(row)}" if row.judged else ""
        lines.append(f"{row.what} (n {row.n}): {values} {row.unit}; {goal} {verdict(row)}")
        lines += [f"    {name}: {value}" for name, value in row.detail.items() if value]
    return "\n".join(lines)


def to_markdown(published: Published, *, is_stale: bool) -> str:
    """Set the published rows as the README has them; what the goal is about is bold."""
    head = ["measured", "n", *published.columns, "goal", ""]
    lines = [head, ["---"] * len(head)]
    for row in published.rows:
        values = [_cell(row, column) for column in published.columns]
        words = verdict(row).replace("missed", "**missed**") + (", stale" if is_stale else "")
        lines.append(
            [
                _what(row, published.columns),
                f"{row.n}",
                *values,
                _goal(row),
                words.removeprefix(", "),
            ]
        )
    table = "\n".join(f"| {' | '.join(cells)} |" for cells in lines)
    origin = fill(_origin(published, is_stale=is_stale), 100, break_on_hyphens=False)
    return f"{table}\n\n{origin}\n"


def verdict(row: Row) -> str:
    if row.met is None:
        return "" if row.goal is None else "not measured"
    return "met" if row.met else "missed"


def number(value: float | None) -> str:
    """Format with three significant digits and no exponent."""
    if value is None:
        return "–"
    if value and abs(value) < 100:
        return f"{value:.3g}"
    return f"{value:.0f}"


def _what(row: Row, columns: Sequence[str]) -> str:
    """Say what a row is of, with its value where that has no column of its own."""
    what = row.what.replace("|", "\\|")
    value = row.values.get(row.judged)
    if value is None or row.judged in columns:
        return what
    return f"{what}: {_with_unit(value, row.unit)}"


def _goal(row: Row) -> str:
    sign = "≥" if row.at_least else "≤"
    return "" if row.goal is None else f"{sign} {_with_unit(row.goal, row.unit)}"


def _cell(row: Row, column: str) -> str:
    value = row.values.get(column)
    if value is None:
        return "–"
    text = _with_unit(value, row.unit)
    return f"**{text}**" if column == row.judged else text


def _with_unit(value: float, unit: str) -> str:
    return f"{number(value)} {unit}".strip()


def _served(rows: Sequence[Row]) -> list[str]:
    """Return what was served meanwhile as a sentence, and in how many rows if not in all."""
    loads = Counter(row.load for row in rows if row.load)
    if not loads:
        return []
    if loads.total() == len(rows) and len(loads) == 1:
        return [f"Served meanwhile: {', '.join(loads)}."]
    each = "; in ".join(f"{count}: {load}" for load, count in loads.items())
    return [f"Served meanwhile, of {len(rows)} rows in {each}."]


def _origin(published: Published, *, is_stale: bool) -> str:
    """Return the figures' origin in sentences."""
    load = "" if published.load is None else f", load {published.load:g} before"
    what = f"{published.date}, commit {published.commit}, {published.machine}{load}."
    said = [what, *_served(published.rows), *published.notes]
    if is_stale:
        said.append(f"Stale: {published.source or 'the product has changed since'}.")
    return " ".join(said)
