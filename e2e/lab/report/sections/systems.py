"""All systems side by side on every link, today's first of all."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from e2e.lab.report import pick, tables, thesis
from e2e.lab.report.blocks import Finding, Folded, Line, Row, Section, Table
from e2e.lab.report.measures import MEASURES
from e2e.lab.report.names import OF_THE_THESIS, SYSTEMS, about
from e2e.lab.report.shown import NOTHING, SAME_MS, SAME_SHARE, alike, cell, said, spread

if TYPE_CHECKING:
    from e2e.lab.cell import SystemName
    from e2e.lab.report.blocks import Block
    from e2e.lab.report.pick import Entries

OVERVIEW: Final = (
    ("picture_age_p50_ms", "picture "),
    ("picture_age_p95_ms", "p95 "),
    ("sound_age_p50_ms", "sound "),
    ("skew_p50_ms", "skew "),
    ("pictures_per_s", "fps "),
)


def section(cells: Entries) -> Section:
    here = pick.plain(cells)
    title = "All systems side by side"
    source = "the thesis’s links and those of today; no thesis for the latter"
    if not here:
        return Section("systems", title, source, ("This run has no cell for this.",))
    columns = (
        tables.of("picture_age_p50_ms", "picture_age_p95_ms", head="picture’s age"),
        tables.of("sound_age_p50_ms"),
        tables.of("skew_p50_ms", "absolute_skew_p95_ms", head="skew"),
        tables.of("pictures_per_s"),
        tables.of("longest_freeze_ms"),
        tables.pauses("tone"),
        tables.pauses("concealed"),
        tables.of("first_picture_ms"),
        tables.of("command_round_trip_p50_ms", "command_round_trip_p95_ms", head="command"),
        tables.bytes_per_s("received"),
        tables.bytes_per_s("sent"),
        tables.of("picture_drift_ms_per_min"),
        tables.of("sound_drift_ms_per_min"),
    )
    heads = (Line(""), *(column.head for column in columns))
    blocks: list[Block] = [
        "Chromium, one viewer, test card, audio MU of the thesis policy 500 ms. What several "
        "experiments measured alike is taken together, which the keys behind each figure tell.",
        _overview(here),
    ]
    for profile in pick.profiles(here):
        words = tables.thesis_row(profile, columns)
        rows = ([words] if words else []) + tables.rows_by_system(here, profile, columns)
        blocks.append(
            Folded(
                f"{profile} – {about(profile)}" if about(profile) else profile,
                Table("", heads, tuple(rows)),
                is_open=profile not in OF_THE_THESIS,
            )
        )
    return Section("systems", title, source, tuple(blocks), tuple(findings(here)))


def _overview(here: Entries) -> Table:
    systems = pick.systems(here)
    rows = []
    for profile in pick.profiles(here):
        shown = [said(thesis.VIDEO.get(profile, {}).get("picture_age_p50_ms"))]
        for system in systems:
            entries = pick.on(here, profile, system)
            measures = [MEASURES[name] for name, _ in OVERVIEW]
            prefixes = [prefix for _, prefix in OVERVIEW]
            shown.append(cell(entries, *measures, prefixes=prefixes) if entries else NOTHING)
        rows.append(Row(Line(profile, about(profile)), tuple(shown)))
    return Table(
        "At a glance: ages and skew in ms, pictures per second",
        (Line(""), Line("thesis 2004"), *(Line(SYSTEMS[system]) for system in systems)),
        tuple(rows),
    )


def findings(here: Entries) -> list[Finding]:
    """Say whose picture is the freshest where, and whose comes next; who is alike is one."""
    age = MEASURES["picture_age_p50_ms"]
    freshest: dict[tuple[SystemName, ...], list[str]] = {}
    about_cells: Entries = ()
    for profile in pick.profiles(here):
        medians = {
            system: summed.median
            for system in pick.systems(here)
            if (summed := spread(pick.on(here, profile, system), age))
        }
        if len(medians) < 2:
            continue
        least = min(medians.values())
        first = tuple(system for system in medians if alike(medians[system], least))
        others = [system for system in medians if system not in first]
        greatest = max(medians[system] for system in first)
        text = age.text(least)
        if age.text(greatest) != text:
            text += f" to {age.text(greatest)}"
        text += " ms"
        if others:
            second = min(others, key=medians.__getitem__)
            text += f", then {SYSTEMS[second]} {age.text(medians[second])}"
        freshest.setdefault(first, []).append(f"{profile} ({text})")
        about_cells += pick.on(here, profile)
    if not freshest:
        return []
    order = list(SYSTEMS)
    text = (
        f"The freshest picture, by its median age (within {SAME_MS:.0f} ms or "
        f"{100 * SAME_SHARE:.0f} % nobody is ahead): "
    ) + "; ".join(
        f"{_named(first)} on {', '.join(freshest[first])}"
        for first in sorted(freshest, key=lambda first: [order.index(one) for one in first])
    )
    return [Finding(text + ".", about_cells)]


def _named(systems: tuple[SystemName, ...]) -> str:
    names = [SYSTEMS[system] for system in systems]
    if len(names) == 1:
        return names[0]
    return f"{', '.join(names[:-1])} and {names[-1]} alike"
