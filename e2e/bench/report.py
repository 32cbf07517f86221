"""What is printed: JSON for machines, a short table for people."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from e2e.bench.goals import Goal, Results
    from e2e.bench.machine import Machine

ROUNDING = 4
IDLE_LOAD = 0.5


@dataclass(frozen=True, slots=True)
class Report:
    """One run. `problems` are sentences about what could not be measured."""

    started_utc: str
    took_s: float
    quick: bool
    machine: Machine
    goals: list[Goal]
    measurements: Results
    problems: list[str]


def to_json(report: Report) -> str:
    return json.dumps(_rounded(asdict(report)), indent=2, ensure_ascii=False)


def to_table(report: Report) -> str:
    """Lines of at most about 120 characters."""
    machine = report.machine
    lines = [
        f"{machine.cpu}, {machine.cores} cores; Python {machine.python}, "
        f"aiortc {machine.versions['aiortc']}, {machine.chromium}",
        *_fanout_lines(report.measurements),
        "",
        f"{'goal':<42}{'at most':>10}{'measured':>10}{'stock':>9}  ",
        *(_goal_line(goal) for goal in report.goals),
        *(f"could not measure {problem.splitlines()[0]}" for problem in report.problems),
    ]
    if machine.load_1min_before > IDLE_LOAD:
        lines.append(f"The machine was busy (load {machine.load_1min_before:.1f}): measure again.")
    if report.quick:
        lines.append("A quick run: too short for figures to be quoted.")
    return "\n".join(lines)


def _fanout_lines(results: Results) -> list[str]:
    lines = []
    for name, side in (("ours", results.fanout.ours), ("stock", results.fanout.stock)):
        if side is None:
            continue
        cells = [
            f"{point.viewers}: {point.server_cpu:.2f}"
            + ("!" if point.saturated else "")
            + ("?" if point.flaw else "")
            for point in side.points
        ]
        lines.append(f"CPU by viewers, {name:<6}" + "  ".join(cells))
    if lines:
        lines.append("  (! saturated, ? disturbed; both are left out of the slope)")
    return lines


def _goal_line(goal: Goal) -> str:
    verdict = {True: "met", False: "MISSED", None: "not measured"}[goal.met]
    unit = f" {goal.unit}" if goal.unit else ""
    return (
        f"{goal.name:<42}{_number(goal.at_most) + unit:>10}{_number(goal.result):>10}"
        f"{_number(goal.stock):>9}  {verdict}" + (f"  ({goal.detail})" if goal.detail else "")
    )


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.3g}"


def _rounded(value: object) -> object:
    if isinstance(value, float):
        return round(value, ROUNDING)
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(item) for item in value]
    return value
