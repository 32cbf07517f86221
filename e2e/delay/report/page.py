"""Renders every experiment by one table; every text from a run is escaped."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from pydantic import ValidationError

from e2e.delay import thesis
from e2e.delay.found import Found, apparatus, found, is_never, on, profiles, spread
from e2e.delay.measures import MEASURES
from e2e.delay.names import AGE, changes_s, profile
from e2e.delay.report.experiments import EXPERIMENTS, named
from e2e.delay.results import CellResult
from e2e.measure.results import Result, Results

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.delay.cell import Cell
    from e2e.delay.report.experiments import Column, Experiment
    from e2e.delay.report.plots import Drawn
    from e2e.measure.results import Origin

FOLDER: Final = Path(__file__).parent / "templates"
REPORT: Final = "report.html"


@dataclass(frozen=True, slots=True)
class Line:
    """A text, and what stands behind it, shown on hover."""

    text: str
    title: str = ""


@dataclass(frozen=True, slots=True)
class Shown:
    """One cell of a table; `state` is one of ok, failed, not run, nothing, said."""

    state: str
    lines: tuple[Line, ...]


NOTHING: Final = Shown("nothing", (Line("–", "There is no such cell in this run."),))


@dataclass(frozen=True, slots=True)
class Section:
    """An experiment with what was found: of each profile its rows, (head, cells of the table)."""

    experiment: Experiment
    tables: dict[str, list[tuple[str, list[Shown]]]]
    says: list[str]
    plots: list[Drawn]


def write(folder: Path, cells: Sequence[Cell]) -> Path:
    """Write the page of the newest results in the suite's folder, beside them."""
    path = folder / REPORT
    path.write_text(html(folder, cells), encoding="utf-8")
    return path


def html(folder: Path, cells: Sequence[Cell]) -> str:
    """Make the page: one file with its plots in it, no script; of these cells what there is."""
    results = newest(folder)
    all_found = _with_problems(results, cells)

    def read(cell: Cell) -> CellResult | None:
        path = folder / "cells" / cell.key.replace("/", "-") / "read.json"
        try:
            return CellResult.model_validate_json(path.read_bytes())
        except (OSError, ValidationError):
            return None

    sections = []
    for experiment in EXPERIMENTS:
        here = experiment.takes(all_found)
        tables = {name: _rows(experiment, name, on(here, name)) for name in profiles(here)}
        plots = experiment.draws(here, read)
        sections.append(Section(experiment, tables, experiment.says(here), plots))
    environment = Environment(
        loader=FileSystemLoader(FOLDER),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("page.html").render(
        origin=results[-1].origin if results else None,
        date=results[-1].started_utc[:10] if results else "nothing measured",
        took_min=sum(result.took_s for result in results) / 60,
        load=max((result.load_1min for result in results), default=0.0),
        counted=_counted(all_found, cells),
        missing=_missing(all_found),
        own_errors=apparatus(row for result in results for row in result.rows),
        sections=sections,
        found=all_found,
        measures=MEASURES,
        profile=profile,
        changes_s=changes_s,
        age=AGE,
        half_a_second=thesis.HALF_A_SECOND,
        contradictions=thesis.CONTRADICTIONS,
    )


def newest(folder: Path) -> list[Result]:
    """Give the results of the newest product in a suite's folder; none where there are none."""
    origin: Origin | None = None
    file = Results(folder)
    for line in file.path.read_text(encoding="utf-8").splitlines() if file.path.exists() else ():
        try:
            origin = Result.model_validate_json(line).origin
        except ValidationError:  # torn by a crash, or of another version
            continue
    return [] if origin is None else list(file.of(origin).values())


def _with_problems(results: Sequence[Result], cells: Sequence[Cell]) -> list[Found]:
    """Take what was measured of these cells, and of the others why they were not."""
    by_key = {result.case: result for result in results}
    every = []
    for cell in cells:
        result = by_key.get(cell.key)
        if result is None:
            every.append(Found(cell, problem="it was not asked for yet", status="not run"))
        elif result.status != "ok":
            every.append(Found(cell, problem=result.problem, status=result.status))
        else:
            every += found(result.rows)
    return every


def _rows(
    experiment: Experiment, name: str, cells: Sequence[Found]
) -> list[tuple[str, list[Shown]]]:
    """Make the thesis's rows on a profile, then a row for each system."""
    rows = []
    for head, by_column in experiment.words(name, experiment.columns).items():
        shown = [
            Shown("said", (Line(said.text, said.where),)) if said else NOTHING
            for said in (by_column.get(column.head) for column in experiment.columns)
        ]
        rows.append((head, shown))
    for head, here in named(cells, experiment.row).items():
        rows.append((head, [_shown(column, column.cells(here)) for column in experiment.columns]))
    return rows


def _shown(column: Column, cells: Sequence[Found]) -> Shown:
    """Show each measure on a line, then what failed or was not run, with its sentence."""
    if not cells:
        return NOTHING
    problems = tuple(
        Line(f"{one.status}: {one.problem}", one.cell.key)
        for one in cells
        if one.problem is not None and not one.values
    )
    if len(problems) == len(cells):
        return Shown(cells[0].status, problems[:1])
    lines = [_line(measure, prefix, cells) for measure, prefix in column.shows]
    return Shown("ok", (*lines, *problems))


def _line(name: str, prefix: str, cells: Sequence[Found]) -> Line:
    """Write the median with its spread; on hover each key and its own number."""
    measure, summed = MEASURES[name], spread(cells, name)
    title = "; ".join(f"{one.cell.key}: {_one(name, one)}" for one in cells)
    if summed is None or is_never(cells, name):
        return Line(f"{prefix}never" if is_never(cells, name) else f"{prefix}–", title)
    text = prefix + measure.text(summed.median)
    least, most = measure.text(summed.min), measure.text(summed.max)
    return Line(text if least == most else f"{text} ({least}…{most})", title)


def _one(name: str, one: Found) -> str:
    if name not in one.values:
        return "nothing measured"
    value = one.values[name]
    return "never" if value is None else MEASURES[name].with_unit(value)


def _counted(every: Sequence[Found], cells: Sequence[Cell]) -> str:
    counts = Counter("no picture" if one.problem and one.values else one.status for one in every)
    told = ", ".join(f"{number} {status}" for status, number in counts.items())
    return f"Of {len(cells)} cells: {told}." if cells else "This run has no cells."


def _missing(every: Sequence[Found]) -> dict[str, list[str]]:
    """Give each problem once, with the cells that had it."""
    found_ones: dict[str, list[str]] = {}
    for one in every:
        if one.problem is not None:
            found_ones.setdefault(f"{one.status}: {one.problem}", []).append(one.cell.key)
    return found_ones
