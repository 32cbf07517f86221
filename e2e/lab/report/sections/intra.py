"""E1, after chapter 5.2: audible pauses by network and audio MU; thesis, model, policy, others."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from e2e.lab.client2004.table import MU_LENGTHS_MS
from e2e.lab.report import model2004, pick, tables, thesis
from e2e.lab.report.blocks import Folded, Line, Row, Section, Shown, Table
from e2e.lab.report.measures import HEARD_MS
from e2e.lab.report.names import SYSTEMS, in_order
from e2e.lab.report.plots import intra as plots
from e2e.lab.report.sections import intra_findings
from e2e.lab.report.shown import NOTHING, said

if TYPE_CHECKING:
    from e2e.lab.cell import SystemName
    from e2e.lab.report.model2004 import Difference, Rows
    from e2e.lab.report.pick import Entries
    from e2e.lab.results import Run

BESIDE: Final[tuple[SystemName, ...]] = ("audio-master", "stock", "livekit")
NO_MODEL: Final = Shown("nothing", (Line("–", "The model has no such connection."),))


def section(run: Run, cells: Entries) -> Section:
    here, beside = pick.intra(cells), pick.plain(cells)
    model = model2004.of(run)
    return Section(
        "e1",
        "E1 · Pauses in the sound, by the length of the audio MU",
        "thesis 5.2, intra-stream synchronisation",
        (
            *(finding.text for finding in intra_findings.lossy(here)),
            _table(here, beside, model),
            *_differences(model2004.differences(model)),
            plots.falling(here, model),
            plots.over_time(here),
            plots.one_cell(here),
        )
        if here or model
        else ("This run has no cell of this experiment.",),
        tuple(intra_findings.findings(here, model)),
    )


def _table(here: Entries, beside: Entries, model: Rows) -> Table:
    profiles = pick.profiles(here)
    profiles += [name for name in thesis.SCENES if name not in profiles and model]
    rows: list[Row] = []
    for profile in in_order(profiles):
        rows.append(tables.group(profile))
        for client, by_mu in thesis.AUDIO.get(profile, {}).items():
            head = Line("thesis 2004" + (f": {client}" if client else ""))
            words = tuple(said(by_mu.get(mu_ms)) for mu_ms in MU_LENGTHS_MS)
            rows.append(Row(head, words, kind="thesis"))
        rows += [
            Row(
                Line(f"model of 2004’s client: {scene}"),
                tuple(_model(model.get((scene, mu_ms))) for mu_ms in MU_LENGTHS_MS),
            )
            for scene in thesis.SCENES.get(profile, {})
            if any((scene, mu_ms) in model for mu_ms in MU_LENGTHS_MS)
        ]
        for kind in ("tone", "concealed"):
            column = tables.pauses(kind)
            shown = tuple(
                column.show(intra_findings.of_mu(here, profile, mu_ms)) for mu_ms in MU_LENGTHS_MS
            )
            if any(one != NOTHING for one in shown):
                rows.append(
                    Row(Line(f"thesis policy: {column.head.text}", column.head.title), shown)
                )
        rows += [
            Row(Line(SYSTEMS[system], "Its sound has no MU to choose."), whole=whole)
            for system in BESIDE
            if (whole := tables.both_pauses(pick.on(beside, profile, system))) != NOTHING
        ]
    return Table(
        "Audible pauses by network and length of the audio MU",
        (Line(""), *(Line(f"{mu_ms} ms") for mu_ms in MU_LENGTHS_MS)),
        tuple(rows),
        (
            "Ours: how many a minute, the longest, and all together as a share of the time. A tone "
            "gap is 30 ms or more without the test card’s tone as it was played; a concealment is "
            "100 ms or more that the browser says it made up. One may be heard as the other. "
            f"Gaps of at most {HEARD_MS:.0f} ms stand here but do not count as pauses in what came "
            "out: 2004’s client bridged them (5.2.1.3).",
            "Systems whose sound has no MU to choose have one value for all lengths; on links that "
            "change they stand under E6.",
        ),
    )


def _model(row: model2004.ModelRow | None) -> Shown:
    if row is None:
        return NO_MODEL
    title = f"client2004, {row.scene}, {row.mu_ms} ms: 4 times 60 s with synthetic delays"
    if row.is_clean:
        return Shown("ok", (Line("none", title),))
    return Shown(
        "ok",
        (
            Line(f"{row.pauses_per_s:.1f} per s", title),
            Line(f"longest {row.longest_ms:.0f} ms", title, small=True),
            Line(f"in all {100 * row.silence:.0f} %", title, small=True),
        ),
    )


def _differences(found: list[Difference]) -> tuple[Folded, ...]:
    if not found:
        return ()
    rows = [
        Row(
            Line(one.where),
            (
                Shown("said", (Line(one.thesis, f"thesis {one.section}"),)),
                Shown("ok", (Line(one.model, f"client2004, {one.where}", small=True),)),
            ),
        )
        for one in found
    ]
    title = "Where the model of 2004’s client does not reproduce the thesis"
    heads = (Line(""), Line("thesis 2004"), Line("model"))
    note = (
        "Cells where one has pauses and the other none, or whose longest pauses are more than "
        "twice apart, and figures that come out otherwise."
    )
    return (Folded(title, Table("", heads, tuple(rows), (note,))),)
