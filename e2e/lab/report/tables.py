"""Tables with a row for each system and a column for each thing to know about it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from e2e.lab.report import pick, thesis
from e2e.lab.report.blocks import Line, Row, Shown, Table
from e2e.lab.report.measure import UNITS
from e2e.lab.report.measures import KINDS, MEASURES, counts_concealment, hears_tone
from e2e.lab.report.names import SYSTEMS, about
from e2e.lab.report.shown import cell, figure, partly, problem, said, spread

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from e2e.lab.report.pick import Entries


@dataclass(frozen=True, slots=True)
class Column:
    """`name` is by what the thesis's words for it are found."""

    head: Line
    show: Callable[[Entries], Shown]
    name: str = ""


def of(name: str, *more: str, head: str = "") -> Column:
    """Show one measure, or several of one unit under one another."""
    measures = [MEASURES[one] for one in (name, *more)]
    first = measures[0]
    text = head or first.label
    unit = UNITS[first.unit]
    prefixes = ("", *(f"{measure.label.rpartition(', ')[2]} " for measure in measures[1:]))
    return Column(
        Line(f"{text}, {unit}" if unit else text, first.about),
        lambda entries: cell(entries, *measures, prefixes=prefixes),
        name,
    )


def pauses(kind: Literal["tone", "concealed"]) -> Column:
    """Show how many a minute, the longest and the share of the time; "none" for none."""
    count = MEASURES[f"{kind}_pauses_per_min"]
    longest = MEASURES[f"longest_{kind}_pause_ms"]
    share = MEASURES[f"{kind}_pause_share"]
    told = hears_tone if kind == "tone" else counts_concealment

    def show(entries: Entries) -> Shown:
        whole = problem(entries)
        if whole is not None:
            return whole
        heard = tuple(entry for entry in entries if told(entry.result))
        summed = spread(heard, count)
        line = figure(entries, count)
        if summed is not None and summed.most == 0:
            return Shown("ok", (replace(line, text="none"), *partly(entries)))
        lines = [line]
        if summed is not None:
            lines = [
                replace(line, unit="per min"),
                replace(figure(entries, longest, prefix="longest "), unit="ms", small=True),
                replace(figure(entries, share, prefix="in all "), unit="%", small=True),
            ]
        return Shown("ok", (*lines, *partly(entries)))

    return Column(Line(count.label, f"{count.about}; in all: of the time"), show, f"{kind}_pauses")


def both_pauses(entries: Entries) -> Shown:
    """Show tone gaps and concealments in one place, each with its name."""
    whole = problem(entries)
    if whole is not None:
        return whole
    lines: list[Line] = []
    for kind in ("tone", "concealed"):
        column = pauses(kind)
        first, *more = (one for one in column.show(entries).lines if not one.is_problem)
        lines += [replace(first, text=f"{column.head.text}: {first.text}"), *more]
    return Shown("ok", (*lines, *partly(entries)))


def bytes_per_s(way: Literal["received", "sent"]) -> Column:
    """Show all bytes together and what they were for."""
    total = MEASURES[f"{way}_total_bytes_per_s"]

    def show(entries: Entries) -> Shown:
        whole = problem(entries)
        if whole is not None:
            return whole
        parts = [
            f"{kind} {measure.text(summed.median)}"
            for kind in KINDS
            if (summed := spread(entries, measure := MEASURES[f"{way}_{kind}_bytes_per_s"]))
        ]
        line = figure(entries, total)
        small = [replace(line, text=", ".join(parts), spread="", small=True)] if parts else []
        return Shown("ok", (line, *small, *partly(entries)))

    return Column(Line(f"{way}, kB/s"), show, total.name)


def thesis_row(profile: str, columns: Sequence[Column]) -> Row | None:
    """Give the thesis's own row, None where it has nothing to say about this profile."""
    video = thesis.VIDEO.get(profile, {})
    known = {
        **video,
        **(
            {"tone_pauses": thesis.PAUSES_AT_500[profile]}
            if profile in thesis.PAUSES_AT_500
            else {}
        ),
        **({"skew_p50_ms": thesis.SYNC[profile]} if profile in thesis.SYNC else {}),
    }
    if not any(column.name in known for column in columns):
        return None
    return Row(
        Line("thesis 2004"),
        tuple(said(known.get(column.name)) for column in columns),
        kind="thesis",
    )


def rows_by_system(entries: Entries, profile: str, columns: Sequence[Column]) -> list[Row]:
    """One row for each system on this profile; a failure takes the whole row."""
    found = []
    for system in pick.systems(entries):
        here = pick.on(entries, profile, system)
        if here:
            found.append(row(Line(SYSTEMS[system]), here, columns))
    return found


def row(head: Line, entries: Entries, columns: Sequence[Column]) -> Row:
    whole = problem(entries)
    if whole is not None:
        return Row(head, whole=whole)
    first, *others = (column.show(entries) for column in columns)
    # Which repetitions are missing is told once, not in every column.
    others = [
        replace(shown, lines=tuple(line for line in shown.lines if not line.is_problem))
        for shown in others
    ]
    return Row(head, (first, *others))


def group(profile: str) -> Row:
    """Head the rows of a profile with its name and what it says of itself."""
    words = about(profile)
    return Row(Line(profile), whole=Shown("said", (Line(words),)), kind="group")


def by_profile(title: str, entries: Entries, columns: Sequence[Column], *notes: str) -> Table:
    """Make a table of all profiles: the thesis's row where it has one, then each system's."""
    rows: list[Row] = []
    for profile in pick.profiles(entries):
        rows.append(group(profile))
        words = thesis_row(profile, columns)
        rows += [words] if words else []
        rows += rows_by_system(entries, profile, columns)
    return Table(title, (Line(""), *(column.head for column in columns)), tuple(rows), notes)
