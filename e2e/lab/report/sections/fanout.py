"""E5: what more viewers cost. The thesis serves each at its own pace (3.2, 6.2): no numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

from e2e.lab.report import pick, tables
from e2e.lab.report.blocks import Finding, Line, Row, Section, Table
from e2e.lab.report.measures import MEASURES
from e2e.lab.report.names import SYSTEMS
from e2e.lab.report.plots import fanout as plots
from e2e.lab.report.shown import spread

if TYPE_CHECKING:
    from e2e.lab.cell import SystemName
    from e2e.lab.report.pick import Entries


def section(cells: Entries) -> Section:
    here = pick.compared(
        pick.where(
            cells,
            lambda one: (
                (one.browser, one.content) == ("chromium", "testcard")
                and not (pick.is_changing(one) or one.drives or one.slow)
            ),
        ),
        lambda one: one.viewers > 1 or one.experiment == "E5",
    )
    title = "E5 · Many viewers"
    source = "thesis 3.2 and 6.2: a slow client never slows another; no numbers there"
    if not here:
        return Section("e5", title, source, ("This run has no cell of this experiment.",))
    columns = (
        tables.of("server_cpu_share", head="server CPU, of one core"),
        tables.of("server_memory_mib"),
        tables.of("picture_age_p50_ms", "picture_age_p95_ms", head="first viewer’s picture"),
        tables.of("sound_age_p50_ms"),
        tables.of("command_round_trip_p50_ms", "command_round_trip_p95_ms", head="command"),
        tables.of("pictures_per_s"),
        tables.of("longest_freeze_ms"),
        tables.of("crowd_pictures_per_s_mean", "crowd_pictures_per_s_min", head="crowd’s pictures"),
        tables.of("crowd_lost_share", head="crowd’s packets lost"),
    )
    rows: list[Row] = []
    for profile in pick.profiles(here):
        rows.append(tables.group(profile))
        for system in pick.systems(pick.on(here, profile)):
            for viewers in _viewers(here, profile, system):
                entries = _of(here, profile, system, viewers)
                head = Line(f"{SYSTEMS[system]}, {viewers} viewer{'s' if viewers > 1 else ''}")
                rows.append(tables.row(head, entries, columns))
    table = Table(
        "Server and first viewer by the number of viewers",
        (Line(""), *(column.head for column in columns)),
        tuple(rows),
        (
            "The server’s CPU includes its child processes; 100 % is one core. The crowd is all "
            "viewers but the first, who only count what they receive: the mean of them and the "
            "one that received least.",
            "LiveKit is not here: its viewers join through its own client library, and a crowd of "
            "those was not built.",
        ),
    )
    return Section("e5", title, source, (table, plots.by_viewers(here)), tuple(findings(here)))


def findings(here: Entries) -> list[Finding]:
    """Say what the server took with the fewest and with the most viewers."""
    cpu = MEASURES["server_cpu_share"]
    found = []
    for profile in pick.profiles(here):
        parts: list[str] = []
        about: Entries = ()
        for system in pick.systems(pick.on(here, profile)):
            measured = [
                (viewers, summed, entries)
                for viewers in _viewers(here, profile, system)
                if (summed := spread(entries := _of(here, profile, system, viewers), cpu))
            ]
            if len(measured) < 2:
                continue
            (few, low, least), (many, high, most) = measured[0], measured[-1]
            parts.append(
                f"{SYSTEMS[system]} {cpu.text(low.median)} % with {few} viewer"
                f"{'' if few == 1 else 's'}, {cpu.text(high.median)} % with {many}"
            )
            about += least + most
        if parts:
            text = f"Server CPU, of one core, on {profile}: " + "; ".join(parts) + "."
            found.append(Finding(text, about))
    return [*found, *_crowds(here)]


def _crowds(here: Entries) -> list[Finding]:
    """Say what the largest crowds received: a server that starves them is no cheap one."""
    least, lost = MEASURES["crowd_pictures_per_s_min"], MEASURES["crowd_lost_share"]
    found = []
    for profile in pick.profiles(here):
        parts: list[str] = []
        about: Entries = ()
        for system in pick.systems(pick.on(here, profile)):
            viewers = max(_viewers(here, profile, system))
            entries = _of(here, profile, system, viewers)
            rate, share = spread(entries, least), spread(entries, lost)
            if rate is None or share is None:
                continue
            parts.append(
                f"{SYSTEMS[system]} with {viewers} viewers {least.text(rate.median)} pictures a "
                f"second, {lost.text(share.median)} % of the packets lost"
            )
            about += entries
        if parts:
            text = f"The least that one of the crowd received on {profile}: {'; '.join(parts)}."
            found.append(Finding(text, about))
    return found


def _viewers(here: Entries, profile: str, system: SystemName) -> list[int]:
    return sorted({entry.cell.viewers for entry in pick.on(here, profile, system)})


def _of(here: Entries, profile: str, system: SystemName, viewers: int) -> Entries:
    return pick.where(pick.on(here, profile, system), lambda cell: cell.viewers == viewers)
