"""What is printed: JSON for machines, a table for people."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from e2e.bench.machine import Machine
    from e2e.faults.finding import Figure

_DIGITS: Final = 2
_IDLE_LOAD: Final = 0.5


@dataclass(frozen=True, slots=True)
class Report:
    """One run. `problems` are sentences about what could not be measured."""

    started_utc: str
    took_s: float
    machine: Machine
    figures: list[Figure]
    problems: list[str]

    @property
    def all_met(self) -> bool:
        return not self.problems and all(figure.met for figure in self.figures)


def to_json(report: Report) -> str:
    return json.dumps(_rounded(asdict(report)), indent=2, ensure_ascii=False)


def to_table(report: Report) -> str:
    machine = report.machine
    lines = [
        f"{machine.cpu}, {machine.cores} cores; {machine.chromium}; took {report.took_s:.0f} s",
        "",
        f"{'fault':<32}{'n':>6}{'p50':>8}{'p99':>8}{'max':>8}{'goal':>8}  ",
        *map(_line, report.figures),
        *_curve(report.figures),
        *(f"could not measure {problem.splitlines()[0]}" for problem in report.problems),
    ]
    if machine.load_1min_before > _IDLE_LOAD:
        lines.append(f"The machine was busy (load {machine.load_1min_before:.1f}): measure again.")
    return "\n".join(lines)


def _line(figure: Figure) -> str:
    verdict = "met" if figure.met else "MISSED"
    notes = [figure.what]
    if figure.wrong and figure.goal != 0:
        notes.append(f"wrong: {figure.wrong}")
    if figure.void:
        notes.append(f"void: {figure.void}")
    stands = figure.detail.get("stands_max_ms")
    if stands is not None:
        notes.append(f"stands ≤ {stands:.0f} ms")
    goal = _number(figure.goal) + ("" if figure.judged == "max" else f" {figure.judged}")
    return (
        f"{figure.name:<32}{figure.n:>6}{_number(figure.p50):>8}{_number(figure.p99):>8}"
        f"{_number(figure.max):>8}{goal:>8}  {verdict} ({'; '.join(notes)})"
    )


def _curve(figures: list[Figure]) -> list[str]:
    """Time to live against stops for no reason, where that was measured."""
    for figure in figures:
        curve = figure.detail.get("stops_in_ten_minutes_by_time_to_live")
        if curve:
            cells = "  ".join(f"{ttl}: {stops:g}" for ttl, stops in curve.items())
            return ["", f"stops in 10 min by time to live, same arrivals: {cells}"]
    return []


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.4g}"


def _rounded(value: object) -> object:
    if isinstance(value, float):
        return round(value, _DIGITS)
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(item) for item in value]
    return value
