"""E2, after 5.3: does the sound come with the picture, on the test card and on lips."""

from __future__ import annotations

from typing import TYPE_CHECKING

from e2e.lab.report import pick, thesis
from e2e.lab.report.blocks import Finding, Line, Row, Section, Table
from e2e.lab.report.measures import MEASURES
from e2e.lab.report.names import SYSTEMS, about
from e2e.lab.report.plots import over_time
from e2e.lab.report.shown import NOTHING, alike, cell, said, spread

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.lab.report.pick import Entries


def section(cells: Entries) -> Section:
    card = pick.plain(cells)
    face = pick.where(cells, lambda one: one.content == "face" and one.browser == "chromium")
    if not card and not face:
        return Section(
            "e2",
            "E2 · Sound against picture",
            "thesis 5.3, inter-stream synchronisation",
            ("This run has no cell of this experiment.",),
        )
    return Section(
        "e2",
        "E2 · Sound against picture",
        "thesis 5.3, inter-stream synchronisation",
        (
            _table(
                "On the test card: skew in ms, and 95 % of its size",
                card,
                ("skew_p50_ms", "absolute_skew_p95_ms"),
                ("", "p95 of |skew| "),
                "Above 0 the sound comes after the picture. People notice sound that is early by "
                "45 ms or late by 125 ms (ITU-R BT.1359).",
                f"{thesis.SYNC_JAVA_2.text} ({thesis.SYNC_JAVA_2.where})",
            ),
            over_time.skew(card),
            _table(
                "On a talking face: by how many ms the voice comes after the lips",
                face,
                ("lip_lag_ms", "lip_correlation"),
                ("", "correlation "),
                "Where the opening of the mouth and the loudness of the voice fit best; a low "
                "correlation makes the lag a guess. The thesis’s judges were people (5.3).",
            ),
        ),
        tuple(findings(card)),
    )


def _table(
    title: str, entries: Entries, names: Sequence[str], prefixes: Sequence[str], *notes: str
) -> Table:
    systems = pick.systems(entries)
    rows = []
    for profile in pick.profiles(entries):
        shown = [said(thesis.SYNC.get(profile))]
        for system in systems:
            here = pick.on(entries, profile, system)
            measures = [MEASURES[name] for name in names]
            shown.append(cell(here, *measures, prefixes=prefixes) if here else NOTHING)
        rows.append(Row(Line(profile, about(profile)), tuple(shown)))
    heads = (Line(""), Line("thesis 2004"), *(Line(SYSTEMS[system]) for system in systems))
    return Table(title, heads, tuple(rows), notes)


def findings(card: Entries) -> list[Finding]:
    """Say for each system how far it is out of step, and what the thesis's limit came to.

    Where it is best and where worst is said only if the two can be told apart.
    """
    found: list[Finding] = []
    size = MEASURES["absolute_skew_p95_ms"]
    parts: list[str] = []
    for system in pick.systems(card):
        by_profile = {
            profile: summed.median
            for profile in pick.profiles(card)
            if (summed := spread(pick.on(card, profile, system), size))
        }
        if not by_profile:
            continue
        worst = max(by_profile, key=by_profile.__getitem__)
        best = min(by_profile, key=by_profile.__getitem__)
        if len(by_profile) > 1 and alike(by_profile[best], by_profile[worst]):
            text = f"{SYSTEMS[system]} {size.with_unit(by_profile[worst])} everywhere"
        else:
            text = f"{SYSTEMS[system]} {size.with_unit(by_profile[best])} on {best}"
            if worst != best:
                text += f" to {size.with_unit(by_profile[worst])} on {worst}"
        parts.append(text)
    if parts:
        text = "95 % of the time sound and picture are no further apart than: "
        found.append(Finding(text + "; ".join(parts) + ".", card))
    for profile, limit_ms in thesis.SYNC_LIMIT_MS.items():
        here = pick.on(card, profile, "thesis")
        summed = spread(here, size)
        if summed is not None:
            kept = "keeps" if summed.median <= limit_ms else "does not keep"
            found.append(
                Finding(
                    f"The thesis’s misalignment of at most {limit_ms:.0f} ms on {profile} (5.3.2): "
                    f"our thesis policy {kept} it (p95 {size.with_unit(summed.median)}).",
                    here,
                )
            )
    return found
