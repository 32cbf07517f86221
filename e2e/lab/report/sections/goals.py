"""What was promised beside what was measured, ours and the peers', in one table."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from e2e.lab.report import goals, pick
from e2e.lab.report.blocks import Finding, Line, Row, Section, Shown, Table
from e2e.lab.report.measure import UNITS
from e2e.lab.report.names import SYSTEMS
from e2e.lab.report.shown import NOTHING, partly, problem
from e2e.lab.report.tables import group

if TYPE_CHECKING:
    from e2e.lab.cell import SystemName
    from e2e.lab.report.goals import Judged
    from e2e.lab.report.pick import Entries
    from e2e.lab.report.shown import Spread

HEADS: Final = ("", "goal", "ours", "stock aiortc", "LiveKit", "")
NOTES: Final = (
    "Judged is the median over the repetitions; in brackets the least and the greatest, and how "
    "many there were. Where a goal is not relative to the peers, they were measured once.",
    "Age of the sound: from capture to the ear, the browser’s own estimate of the way from its "
    "jitter buffer to the loudspeaker (media-playout) included. Skew is from these ages, from 3 s "
    "after the first picture on.",
    "Audible pauses: gaps of 30 ms or more in the tone as it was played, or 100 ms or more made up "
    "without a break as the browser counts, whichever are more, from the first sound on.",
    "Driving: the operator’s page holds a key and sends 20 set-points a second. Nobody answers a "
    "set-point; the commands’ round trip is that of the pings that share the channel with them, "
    "from the page’s call to the answer’s event.",
    f"No drift: at most {goals.NO_DRIFT_MS:.0f} ms a minute, which is what a cell of a minute "
    "can tell apart.",
    "Step-down: the times are from when the link was made worse, and from when it was whole again; "
    "full quality is 640×480 at 27 or more pictures in each second.",
    "A further observer’s cost is the difference of the server’s CPU between two crowds of one "
    "repetition, divided by how many more there were; nothing is extrapolated. The crowd answers "
    "as Chromium does: transport-wide feedback, receiver reports, repeats asked for.",
)


def sections(cells: Entries) -> tuple[Section, ...]:
    """Make the section, none where the run was not for the goals."""
    if not pick.where(cells, lambda cell: cell.experiment == "G"):
        return ()
    judged = [goals.judge(goal, cells) for goal in goals.goals(cells)]
    table = Table("", tuple(map(Line, HEADS)), tuple(_rows(judged)), (*NOTES, *_crowds(cells)))
    source = "what issue 4 promises, beside what people use today"
    return (Section("goals", "Goals", source, (table,), tuple(findings(judged))),)


def findings(judged: list[Judged]) -> list[Finding]:
    """Say how many are met, and name those that are not."""
    counts = {
        verdict: sum(one.verdict == verdict for one in judged)
        for verdict in ("met", "missed", "not judged")
    }
    told = ", ".join(f"{number} {verdict}" for verdict, number in counts.items() if number)
    found = [Finding(f"Of {len(judged)} goals: {told}.")]
    for one in judged:
        if one.verdict == "missed":
            text = f"Missed: {one.goal.profile}, {SYSTEMS[one.goal.system]}, {_sentence(one)}."
            found.append(Finding(text, one.cells[one.goal.system]))
    return found


def text(cells: Entries) -> list[str]:
    """Write the same for a terminal, a line for each goal."""
    lines = []
    for one in [goals.judge(goal, cells) for goal in goals.goals(cells)]:
        beside = "".join(
            f", {SYSTEMS[system]} {_number(one, spread)}"
            for system in goals.PEERS
            if (spread := one.found.get(system))
        )
        where = f"{one.goal.profile}, {SYSTEMS[one.goal.system]}"
        lines.append(f"{one.verdict:<11}{where:<28}{_sentence(one)}{beside}")
    return lines


def _sentence(one: Judged) -> str:
    ours = one.found.get(one.goal.system)
    number = "nothing measured" if ours is None else _number(one, ours)
    return f"{one.goal.measure.label}: {number} (goal: {one.goal.words})"


def _number(one: Judged, spread: Spread) -> str:
    if math.isinf(spread.median):
        return "never"
    return f"{one.goal.measure.with_unit(spread.median)}, n {spread.n}"


def _rows(judged: list[Judged]) -> list[Row]:
    rows: list[Row] = []
    before = None
    for one in judged:
        if one.goal.profile != before:
            rows.append(group(one.goal.profile))
            before = one.goal.profile
        measure = one.goal.measure
        ours = one.cells[one.goal.system]
        seconds = sorted({entry.cell.seconds for entry in ours})
        lasted = " and ".join(f"{length:g}" for length in seconds) or "0"
        shown = (
            Shown("said", (Line(one.goal.words),)),
            _shown(one, one.goal.system),
            *(_shown(one, system) for system in goals.PEERS),
            _verdict(one),
        )
        head = f"{SYSTEMS[one.goal.system]}: {measure.label}"
        rows.append(Row(Line(head, f"{measure.about} Cells of {lasted} s.".strip()), shown))
    return rows


def _shown(one: Judged, system: SystemName) -> Shown:
    entries, spread = one.cells[system], one.found.get(system)
    if not entries:
        return NOTHING
    whole = problem(entries)
    if whole is not None:
        return whole
    anchor = entries[0].anchor
    title = "; ".join(entry.key for entry in entries)
    if spread is None:
        return Shown("nothing", (Line("–", title, anchor), *partly(entries)))
    measure = one.goal.measure
    line = Line(_plain(one, spread.median), title, anchor)
    if spread.least != spread.most:
        least, most = _plain(one, spread.least), _plain(one, spread.most)
        line = replace(line, spread=f"({least}…{most})")
    unit = UNITS[measure.unit]
    return Shown("ok", (replace(line, unit=f"{unit}, n {spread.n}".lstrip(", ")), *partly(entries)))


def _plain(one: Judged, value: float) -> str:
    return "never" if math.isinf(value) else one.goal.measure.text(value)


def _verdict(one: Judged) -> Shown:
    state = {"met": "ok", "missed": "failed", "not judged": "nothing"}[one.verdict]
    spread = one.found.get(one.goal.system)
    few = spread is not None and spread.n < 3
    text = f"{one.verdict}, of {spread.n}" if spread and few else one.verdict
    return Shown(state, (Line(text),))  # type: ignore[arg-type]  # one of its three words


def _crowds(cells: Entries) -> tuple[str, ...]:
    """Say which crowds there were, how slow ones fared, and whether the machine could carry it."""
    parts = []
    systems: tuple[SystemName, ...] = ("operator", "stock")
    for system in systems:
        numbers = goals.observers(cells, system)
        if numbers:
            sizes = " and ".join(map(str, numbers))
            parts.append(f"{SYSTEMS[system]} with {sizes} observers")
    if not parts:
        return ()
    crowds = pick.where(cells, lambda cell: cell.viewers > 1)
    busy = [_told(entry.result.told, "machine.busy_share") for entry in crowds]
    known = [one for one in busy if one is not None]
    told = (
        f" At its busiest {100 * max(known):.0f} % of the whole machine was used." if known else ""
    )
    slow = max((entry.cell.slow for entry in crowds), default=0)
    behind = f" Of the largest crowd {slow} were behind a modem of 50 kbit/s each." if slow else ""
    return (f"Run were: {'; '.join(parts)}.{behind}{told}",)


def _told(told: dict[str, float | str], name: str) -> float | None:
    value = told.get(name)
    return float(value) if isinstance(value, float | int) else None
