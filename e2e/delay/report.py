"""``python -m e2e.delay.report``: all that a suite's results hold, as one page of tables.

A table for each link: the systems in rows, the figures in columns, and what the thesis says of it.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from e2e.delay.judging import found
from e2e.delay.measures import MEASURES
from e2e.delay.names import AGE, GIVEN, LINKS, SYSTEMS, profile, shown
from e2e.delay.thesis import words
from e2e.measure.command import OUT
from e2e.measure.results import Results
from e2e.measure.row import summarize
from e2e.measure.table import number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.delay.cell import Cell
    from e2e.delay.judging import Found
    from e2e.measure.results import Result


def write(folder: Path) -> Path | None:
    """Write the page beside the results of the newest product; None where there are none."""
    results = Results(folder).newest()
    if not results:
        return None
    path = folder / "report.html"
    path.write_text(html(results), encoding="utf-8")
    print(f"report: {path}", file=sys.stderr)
    return path


def html(results: Sequence[Result]) -> str:
    """Make the page: no script, every text escaped."""
    cells = found(row for result in results for row in result.rows)
    names = sorted({one.cell.profile for one in cells}, key=lambda one: (*LINKS, one).index(one))
    links = [_link(name, [one for one in cells if one.cell.profile == name]) for name in names]
    problems = [f"{one.case}: {one.problem}" for one in results if one.problem]
    loader = FileSystemLoader(Path(__file__).parent)
    page = Environment(loader=loader, autoescape=True, undefined=StrictUndefined)
    return page.get_template("report.jinja").render(
        origin=results[-1].origin, notes=(AGE, *GIVEN, *problems), links=links
    )


def _link(name: str, cells: Sequence[Found]) -> dict[str, Any]:
    """Return a table; each value comes with what is told on hover."""
    columns = [one for one in MEASURES if any(one in cell.values for cell in cells)]
    rows: list[tuple[str, str, list[tuple[str, str]]]] = []
    for mu_ms in sorted({one.cell.audio_mu_ms or 500 for one in cells}):
        if said := words(name, mu_ms):
            texts = {one: (said[one].text, said[one].where) for one in said}
            values = [texts.get(one, ("", "")) for one in columns]
            rows.append((f"thesis, {mu_ms} ms", "said", [("", ""), *values]))
    groups: dict[str, list[Found]] = {}
    for one in sorted(cells, key=lambda one: list(SYSTEMS).index(one.cell.system)):
        groups.setdefault(one.cell.variant, []).append(one)
    for here in groups.values():
        values = [(f"{len(here)}", ""), *(_value(measure, here) for measure in columns)]
        rows.append((_who(here[0].cell), "", values))
    heads = [", ".join(filter(None, MEASURES[one])) for one in columns]
    return {"name": shown(name), "about": profile(name).about, "heads": heads, "rows": rows}


def _who(cell: Cell) -> str:
    but = (shown(cell.profile), cell.system)
    more = " ".join(part for part in cell.variant.split("/") if part not in but)
    return f"{SYSTEMS[cell.system]} {more}".strip()


def _value(measure: str, cells: Sequence[Found]) -> tuple[str, str]:
    """Write the median; behind it, on hover, each repetition's number."""
    tried = [(one.cell.key, one.values[measure]) for one in cells if measure in one.values]
    known = [value for _, value in tried if value is not None]
    told = "; ".join(f"{key}: {'never' if one is None else number(one)}" for key, one in tried)
    if 2 * len(known) < len(tried) or not known:
        return ("never" if tried else "–"), told
    return number(summarize(known).median), told


if __name__ == "__main__":
    write(OUT / "delay")
