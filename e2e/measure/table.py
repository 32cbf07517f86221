"""Formats rows for the terminal, and as a table of Markdown."""

from __future__ import annotations

from collections import Counter
from textwrap import fill
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.measure.published import Published
    from e2e.measure.row import Row

_PEERS: Final = ("WAX", "stock aiortc", "LiveKit", "LiveKit, one layer")


def to_table(rows: Sequence[Row]) -> str:
    """Format rows as lines for the terminal, with their explanations."""
    lines = []
    for row in rows:
        values = "  ".join(f"{name} {number(value)}" for name, value in row.values.items())
        goal = f"{row.judged} {_goal(row)}" if row.judged else ""
        lines.append(f"{row.what} (n {row.n}): {values} {row.unit}; {goal} {verdict(row)}")
        lines += [f"    {name}: {value}" for name, value in row.detail.items() if value]
    return "\n".join(lines)


def to_markdown(published: Published) -> str:
    """Format a suite's rows and their origin as Markdown; judged values are bold."""
    return _table(published.rows, published.columns, _origin(published))


def to_headline(found: Sequence[tuple[Published, Row]]) -> str:
    """Format a few rows of several suites as one table beside the peers, with each origin once."""
    lines = [["measured", "n", *_PEERS, "beside the best of them"]]
    for _, row in found:
        ours = row.values.get(row.judged)
        values = {column: row.values.get(column) for column in _PEERS} | {_PEERS[0]: ours}
        here = row.model_copy(update={"values": values, "judged": _PEERS[0]})
        cells = [_cell(here, column) for column in _PEERS]
        lines.append([row.what, f"{row.n}", *cells, _beside(here)])
    origins = dict.fromkeys(_measured_at(published) for published, _ in found)
    return _markdown(lines, f"{'; '.join(origins)}.")


def _beside(row: Row) -> str:
    """Say how much less, or with `at_least` more, WAX has than the best peer, unless that has 0."""
    ours, *peers = (row.values[column] for column in _PEERS)
    known = [value for value in peers if value is not None]
    best = (max if row.at_least else min)(known, default=0.0)
    if ours is None or not best:
        return ""
    gain = ours / best - 1 if row.at_least else 1 - ours / best
    return f"{abs(gain):.0%} {'better' if gain >= 0 else 'worse'}".replace("%", " %")


def _table(rows: Sequence[Row], columns: Sequence[str], origin: str) -> str:
    lines = [["measured", "n", *columns, "goal", ""]]
    for row in rows:
        values = [_cell(row, column) for column in columns]
        words = verdict(row).replace("missed", "**missed**")
        lines.append([_what(row, columns), f"{row.n}", *values, _goal(row), words])
    return _markdown(lines, origin)


def _markdown(lines: Sequence[Sequence[str]], origin: str) -> str:
    head, *body = lines
    table = "\n".join(f"| {' | '.join(cells)} |" for cells in (head, ["---"] * len(head), *body))
    return f"{table}\n\n{fill(origin, 100, break_on_hyphens=False)}\n"


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
    """Describe a row, with its value if that has no column of its own."""
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


def _origin(published: Published) -> str:
    """Return the figures' origin in sentences."""
    load = "" if published.load is None else f", load {published.load:g} before"
    what = f"{_measured_at(published)}, {published.machine}{load}."
    return " ".join([what, *_served(published.rows), *published.notes])


def _measured_at(published: Published) -> str:
    version = f"Version {published.version}, commit" if published.version else "Commit"
    return f"{version} {published.commit}, {published.date}"


def _served(rows: Sequence[Row]) -> list[str]:
    """Return the server's load during the rows as sentences, and in how many rows if not in all."""
    loads = Counter(row.load for row in rows if row.load)
    if not loads:
        return []
    counts = (f"{load} ({count} of the {len(rows)} rows)" for load, count in loads.items())
    said = loads if [*loads.values()] == [len(rows)] else counts
    return [f"The server meanwhile served {' or '.join(said)}."]
