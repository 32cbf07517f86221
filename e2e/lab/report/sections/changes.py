"""E6: the link changes under way; how bad it gets and how long until it is good again."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Literal

from e2e.lab.report import pick, recovery, tables
from e2e.lab.report.blocks import Finding, Line, Section, Shown
from e2e.lab.report.names import SYSTEMS, changes_s
from e2e.lab.report.plots import over_time
from e2e.lab.report.shown import cell, spread

if TYPE_CHECKING:
    from e2e.lab.report.pick import Entries


def section(cells: Entries) -> Section:
    here = pick.changing(cells)
    title, source = "E6 · A link that changes", "not in the thesis: a step of the rate, an outage"
    if not here:
        return Section("e6", title, source, ("This run has no cell of this experiment.",))
    columns = (
        _recovered("picture", "adapted"),
        _recovered("picture", "recovered"),
        _recovered("sound", "adapted"),
        _recovered("sound", "recovered"),
        tables.of("picture_age_p95_ms"),
        tables.of("longest_freeze_ms"),
        tables.pauses("tone"),
        tables.pauses("concealed"),
        tables.of("picture_drift_ms_per_min"),
    )
    return Section(
        "e6",
        title,
        source,
        (
            *_schedules(here),
            tables.by_profile(
                "Time to recover, and how bad it got",
                here,
                columns,
                "Recovered: from the change until the age is, and stays for about a second, at "
                f"most {recovery.MARGIN_MS:.0f} ms above its median before the first change.",
            ),
            over_time.ages(here, "picture"),
            over_time.ages(here, "sound"),
        ),
        tuple(findings(here)),
    )


def _schedules(here: Entries) -> list[str]:
    return [
        f"{profile}: " + "; ".join(f"at {at_s:g} s {words}" for at_s, words in changes) + "."
        for profile in pick.profiles(here)
        if (changes := changes_s(profile))
    ]


def _recovered(
    of: Literal["picture", "sound"], what: Literal["adapted", "recovered"]
) -> tables.Column:
    measure = recovery.MEASURES[f"{of}_{what}_ms"]
    when = "first" if what == "adapted" else "last"

    def show(entries: Entries) -> Shown:
        shown = cell(entries, measure)
        never = [entry for entry in entries if recovery.can_tell(entry.result, of)]
        if shown.state != "ok" or spread(entries, measure) is not None or not never:
            return shown
        return replace(
            shown,
            lines=(
                replace(
                    shown.lines[0],
                    text="not before the next change" if what == "adapted" else "not reached",
                ),
                *shown.lines[1:],
            ),
        )

    return tables.Column(Line(f"{of} recovered after the {when} change, ms"), show, measure.name)


def findings(here: Entries) -> list[Finding]:
    """Name the quickest and the slowest to show a fresh picture again."""
    measure = recovery.MEASURES["picture_recovered_ms"]
    found = []
    for profile in pick.profiles(here):
        on_it = pick.on(here, profile)
        times = {
            system: summed.median
            for system in pick.systems(on_it)
            if (summed := spread(pick.on(on_it, profile, system), measure))
        }
        never = [
            SYSTEMS[system]
            for system in pick.systems(on_it)
            if system not in times
            and any(
                recovery.can_tell(one.result, "picture") for one in pick.on(on_it, profile, system)
            )
        ]
        parts = [
            f"{SYSTEMS[system]} {measure.with_unit(time_ms)}"
            for system, time_ms in sorted(times.items(), key=lambda item: item[1])
        ]
        if parts or never:
            text = f"After the last change of {profile} the picture is as before: "
            text += ", ".join(
                [*(f"{part}" for part in parts), *(f"{one} not at all" for one in never)]
            )
            found.append(Finding(text + ".", on_it))
    return found
