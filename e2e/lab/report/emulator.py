"""What a run found of the emulator, as a sentence and a table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ValidationError

from e2e.lab.report.blocks import Line, Row, Shown, Table

if TYPE_CHECKING:
    from e2e.lab.report.blocks import State
    from e2e.lab.results import Run


class _Figure(BaseModel):
    name: str
    promised: float | None
    measured: float | None
    """None where nothing came."""
    allowed: float | None
    ok: bool


class _Verified(BaseModel):
    profile: str
    ok: bool
    problem: str | None = None
    figures: dict[str, list[_Figure]] = {}
    notes: list[str] = []


@dataclass(frozen=True, slots=True)
class Emulator:
    text: str
    table: Table


def emulator(run: Run) -> Emulator | None:
    """Tell what was verified; None where nothing was. What is no such row is left out."""
    found = [one for given in run.emulator if (one := _verified(given))]
    if not found:
        return None
    figures = [figure for one in found for way in one.figures.values() for figure in way]
    good = sum(figure.ok for figure in figures)
    text = (
        f"Measured with packets of its own before the cells: {good} of {len(figures)} figures of "
        f"{len(found)} profile{'' if len(found) == 1 else 's'} are within 5 %, or within what "
        "chance does to the sample."
    )
    off = [one.profile for one in found if not one.ok]
    if off:
        text += f" Not so on {', '.join(off)}; trust what was measured there less."
    heads = ("", "promised", "measured", "allowed ±")
    rows = [row for one in found for row in _rows(one)]
    return Emulator(text, Table("", tuple(map(Line, heads)), tuple(rows)))


def _verified(given: dict[str, Any]) -> _Verified | None:
    try:
        return _Verified.model_validate(given)
    except ValidationError:
        return None


def _rows(one: _Verified) -> list[Row]:
    words = one.problem or "; ".join(one.notes)
    rows = [Row(Line(one.profile), whole=Shown("said", (Line(words),)), kind="group")]
    for way, figures in one.figures.items():
        for figure in figures:
            title = f"{one.profile}, {way}, {figure.name}"
            state: State = "ok" if figure.ok else "failed"
            rows.append(
                Row(
                    Line(f"{way}: {figure.name}"),
                    tuple(
                        Shown(state, (Line(_text(value), title),))
                        for value in (figure.promised, figure.measured, figure.allowed)
                    ),
                )
            )
    return rows


def _text(value: float | None) -> str:
    return "–" if value is None else f"{value:.4g}"
