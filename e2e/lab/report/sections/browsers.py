"""E4, after 5.5: one browser beside the other, and what each does not tell."""

from __future__ import annotations

from typing import TYPE_CHECKING

from e2e.lab.report import pick, tables, thesis
from e2e.lab.report.blocks import Line, Row, Section, Table
from e2e.lab.report.names import SYSTEMS

if TYPE_CHECKING:
    from e2e.lab.report.pick import Entries


def section(cells: Entries) -> Section:
    here = pick.compared(
        pick.where(cells, lambda one: one.viewers == 1 and one.content == "testcard"),
        lambda one: one.browser != "chromium" or one.experiment == "E4",
    )
    title, source = "E4 · Browsers", "thesis 5.5, portability and compatibility"
    in_2004 = "In 2004: " + "; ".join(f"{said.text} ({said.where})" for said in thesis.BROWSERS)
    if not here:
        return Section(
            "e4", title, source, (in_2004 + ".", "This run has no cell of this experiment.")
        )
    columns = (
        tables.of("first_picture_ms"),
        tables.of("picture_age_p50_ms", "picture_age_p95_ms", head="picture’s age"),
        tables.of("sound_age_p50_ms"),
        tables.of("skew_p50_ms"),
        tables.of("pictures_per_s"),
        tables.of("longest_freeze_ms"),
        tables.pauses("tone"),
        tables.pauses("concealed"),
        tables.of("command_round_trip_p50_ms"),
    )
    rows: list[Row] = []
    for profile in pick.profiles(here):
        rows.append(tables.group(profile))
        on_it = pick.on(here, profile)
        for system in pick.systems(on_it):
            for browser in ("chromium", "firefox"):
                entries = pick.where(
                    on_it,
                    lambda cell, system=system, browser=browser: (  # type: ignore[misc]  # no type for a default
                        (cell.system, cell.browser) == (system, browser)
                    ),
                )
                if entries:
                    head = Line(f"{SYSTEMS[system]}, {browser.capitalize()}")
                    rows.append(tables.row(head, entries, columns))
    table = Table(
        "Chromium beside Firefox",
        (Line(""), *(column.head for column in columns)),
        tuple(rows),
    )
    return Section("e4", title, source, (in_2004 + ".", table, *_limits(here)))


def _limits(here: Entries) -> list[str]:
    found: dict[tuple[str, str], None] = {}
    for entry in here:
        if entry.result.readings is not None:
            for limit in entry.result.readings.limits:
                found[entry.cell.browser, limit] = None
    return [f"{browser.capitalize()}: {limit}" for browser, limit in found]
