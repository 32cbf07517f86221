"""Rows as a person reads them: in the terminal, and as a table of Markdown."""

from __future__ import annotations

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
        lines.append(f"{row.what} (n {row.n}): {values} {row.unit}; {goal(row)} {verdict(row)}")
        lines += [f"    {name}: {value}" for name, value in row.detail.items() if value]
    return "\n".join(lines)


def to_markdown(published: Published, *, is_stale: bool) -> str:
    """Set the published rows as the README has them, without the markers around."""
    head = ["", "n", *published.columns, "goal", ""]
    lines = [head, ["---"] * len(head)]
    for row in published.rows:
        values = [_cell(row, column) for column in published.columns]
        words = verdict(row) + (", stale" if is_stale else "")
        lines.append([row.what, f"{row.n}", *values, goal(row), words.removeprefix(", ")])
    table = "\n".join(f"| {' | '.join(cells)} |" for cells in lines)
    return f"{table}\n\n{_origin(published, is_stale=is_stale)}\n"


def goal(row: Row) -> str:
    if row.goal is None:
        return ""
    sign = "≥" if row.at_least else "≤"
    return f"{row.judged} {sign} {_with_unit(row.goal, row.unit)}"


def verdict(row: Row) -> str:
    return {True: "met", False: "**missed**", None: ""}[row.met]


def number(value: float | None) -> str:
    """Three digits that count, and no exponent."""
    if value is None:
        return "–"
    if value and abs(value) < 100:
        return f"{value:.3g}"
    return f"{value:.0f}"


def _cell(row: Row, column: str) -> str:
    value = row.values.get(column)
    if value is None:
        return "–"
    text = _with_unit(value, row.unit)
    return f"**{text}**" if column == row.judged else text


def _with_unit(value: float, unit: str) -> str:
    return f"{number(value)} {unit}".strip()


def _origin(published: Published, *, is_stale: bool) -> str:
    """Say where the figures come from, in sentences."""
    load = "" if published.load is None else f", load {published.load:g} before"
    what = f"{published.date}, commit {published.commit}, {published.machine}{load}."
    said = [what, *published.notes]
    if is_stale:
        said.append(f"Stale: {published.source or 'the product has changed since'}.")
    return " ".join(said)
