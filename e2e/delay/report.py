"""``python -m e2e.delay.report``: all that a suite's results hold, as one page of tables.

A table for each link: the systems in rows, the figures in columns, and what the thesis says of it.
"""

from __future__ import annotations

import sys
from html import escape
from typing import TYPE_CHECKING, Final

from pydantic import ValidationError

from e2e.delay.judging import found
from e2e.delay.measures import MEASURES
from e2e.delay.names import AGE, GIVEN, LINKS, SYSTEMS, profile, shown
from e2e.delay.thesis import words
from e2e.measure.command import OUT
from e2e.measure.results import Result, Results
from e2e.measure.row import summarize
from e2e.measure.table import number

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence
    from pathlib import Path

    from e2e.delay.cell import Cell
    from e2e.delay.judging import Found

_STYLE: Final = (
    "body{font:14px system-ui;margin:2em}table{border-collapse:collapse}"
    "td,th{border:1px solid #999;padding:2px 6px;text-align:right;vertical-align:top}"
    "th:first-child{text-align:left}.said{font-style:italic}"
)


def write(folder: Path) -> Path | None:
    """Write the page beside the results of the newest product; None where there are none."""
    results = newest(folder)
    if not results:
        return None
    path = folder / "report.html"
    path.write_text(html(results), encoding="utf-8")
    print(f"report: {path}", file=sys.stderr)
    return path


def newest(folder: Path) -> list[Result]:
    """Give the results that count beside the newest one."""
    file = Results(folder)
    lines = file.path.read_text(encoding="utf-8").splitlines() if file.path.exists() else []
    for line in reversed(lines):
        try:
            return list(file.of(Result.model_validate_json(line).origin).values())
        except ValidationError:  # torn by a crash, or of another version
            continue
    return []


def html(results: Sequence[Result]) -> str:
    """Make the page: no script, every text escaped."""
    origin = results[-1].origin
    cells = found(row for result in results for row in result.rows)
    problems = [f"{one.case}: {one.problem}" for one in results if one.problem]
    links = {one.cell.profile for one in cells}
    parts = [
        '<!doctype html><html lang="en"><meta charset="utf-8"><title>Delay</title>',
        f"<style>{_STYLE}</style><h1>Delay</h1>",
        f"<p>Commit {escape(origin.commit)}, {escape(str(origin.machine))}.</p>",
        *(f"<p>{escape(one)}</p>" for one in (AGE, *GIVEN, *problems)),
        *(
            part
            for link in sorted(links, key=lambda one: (*LINKS, one).index(one))
            for part in _link(link, [one for one in cells if one.cell.profile == link])
        ),
    ]
    return "\n".join(parts)


def _link(name: str, cells: Sequence[Found]) -> Iterator[str]:
    columns = [one for one in MEASURES if any(one in cell.values for cell in cells)]
    yield f"<h2>{escape(shown(name))}</h2><p>{escape(profile(name).about)}</p><table>"
    heads = (f"{label}, {unit}".rstrip(", ") for label, unit in map(MEASURES.__getitem__, columns))
    yield _row("th", ["n", *heads], "")
    for mu_ms in sorted({one.cell.audio_mu_ms or 500 for one in cells}):
        if said := words(name, mu_ms):
            texts = {one: (said[one].text, said[one].where) for one in said}
            values = [texts.get(one, ("", "")) for one in columns]
            yield _row("td", [("", ""), *values], f"thesis, {mu_ms} ms", "said")
    groups: dict[str, list[Found]] = {}
    for one in sorted(cells, key=lambda one: list(SYSTEMS).index(one.cell.system)):
        groups.setdefault(one.cell.variant, []).append(one)
    for here in groups.values():
        values = [(f"{len(here)}", ""), *(_value(measure, here) for measure in columns)]
        yield _row("td", values, _who(here[0].cell))
    yield "</table>"


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


def _row(tag: str, values: Iterable[str | tuple[str, str]], head: str, kind: str = "") -> str:
    pairs = (value if isinstance(value, tuple) else (value, "") for value in values)
    texts = "".join(f'<{tag} title="{escape(why)}">{escape(one)}</{tag}>' for one, why in pairs)
    return f'<tr class="{kind}"><th>{escape(head)}</th>{texts}</tr>'


if __name__ == "__main__":
    write(OUT / "delay")
