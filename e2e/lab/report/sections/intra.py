"""E1, after 5.2: audible pauses by network and audio MU; thesis, model, policy."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from e2e.lab.client2004.table import CLEAN_PER_S
from e2e.lab.report import model2004, pick, tables, thesis
from e2e.lab.report.blocks import Finding, Line, Row, Section, Shown, Table
from e2e.lab.report.measures import MEASURES
from e2e.lab.report.names import in_order
from e2e.lab.report.plots import intra as plots
from e2e.lab.report.shown import NOTHING, problem, said, spread

if TYPE_CHECKING:
    from e2e.lab.report.pick import Entries
    from e2e.lab.results import Run

MUS_MS: Final = (100, 200, 300, 400, 500)
CLEAN_PER_MIN: Final = 60 * CLEAN_PER_S
"""Fewer than one in 20 s count as none, as for the model."""

NO_MODEL: Final = Shown("nothing", (Line("–", "The model has no such connection."),))


def section(run: Run, cells: Entries) -> Section:
    here = pick.where(pick.common(cells), lambda cell: cell.system == "thesis")
    model = model2004.of(run)
    return Section(
        "e1",
        "E1 · Pauses in the sound, by the length of the audio MU",
        "thesis 5.2, intra-stream synchronisation",
        (
            _table(here, model),
            plots.falling(here, model),
            plots.over_time(here),
            plots.one_cell(here),
        )
        if here or model
        else ("This run has no cell of this experiment.",),
        tuple(findings(here)),
    )


def of_mu(entries: Entries, profile: str, mu_ms: int) -> Entries:
    return pick.where(entries, lambda cell: cell.profile == profile and pick.mu_ms(cell) == mu_ms)


def _table(here: Entries, model: dict[tuple[str, int], model2004.ModelRow]) -> Table:
    profiles = pick.profiles(here)
    profiles += [name for name in thesis.SCENES if name not in profiles and model]
    rows: list[Row] = []
    for profile in in_order(profiles):
        rows.append(tables.group(profile))
        for client, by_mu in thesis.AUDIO.get(profile, {}).items():
            head = Line("thesis 2004" + (f": {client}" if client else ""))
            rows.append(Row(head, tuple(said(by_mu.get(mu_ms)) for mu_ms in MUS_MS), kind="thesis"))
        rows += [
            Row(
                Line(f"model of 2004’s client: {scene}"),
                tuple(_model(model.get((scene, mu_ms))) for mu_ms in MUS_MS),
            )
            for scene in thesis.SCENES.get(profile, {})
            if any((scene, mu_ms) in model for mu_ms in MUS_MS)
        ]
        for kind in ("tone", "concealed"):
            column = tables.pauses(kind)
            shown = tuple(column.show(of_mu(here, profile, mu_ms)) for mu_ms in MUS_MS)
            if any(one != NOTHING for one in shown):
                rows.append(
                    Row(Line(f"thesis policy: {column.head.text}", column.head.title), shown)
                )
    return Table(
        "Audible pauses by network and length of the audio MU",
        (Line(""), *(Line(f"{mu_ms} ms") for mu_ms in MUS_MS)),
        tuple(rows),
        (
            "Ours: how many a minute, the longest, and all together as a share of the time. A tone "
            "gap is 30 ms or more without the test card’s tone as it was played; a concealment is "
            "100 ms or more that the browser says it made up. One may be heard as the other.",
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


def pauses_per_min(entries: Entries) -> float | None:
    """Tone gaps or concealments, whichever are more, as either can be heard."""
    both = [
        summed.median
        for name in ("tone_pauses_per_min", "concealed_pauses_per_min")
        if (summed := spread(entries, MEASURES[name]))
    ]
    return max(both, default=None)


def findings(here: Entries) -> list[Finding]:
    """Say where the policy has pauses and the thesis none, and the other way round."""
    agree = 0
    ours_only: list[tuple[str, Entries]] = []
    theirs_only: list[tuple[str, Entries]] = []
    for profile, clients in thesis.AUDIO.items():
        # Where several clients were tried, the first is the thesis's own measure of the network.
        by_mu = next(iter(clients.values())) | _only_windows(clients)
        for mu_ms, words in by_mu.items():
            entries = of_mu(here, profile, mu_ms)
            ours = pauses_per_min(entries)
            if ours is None or problem(entries) is not None:
                continue
            has = ours >= CLEAN_PER_MIN
            if has == (not words.none):
                agree += 1
            elif has:
                ours_only.append((f"{profile} at {mu_ms} ms ({ours:.0f} a minute)", entries))
            else:
                theirs_only.append((f"{profile} at {mu_ms} ms ({words.text})", entries))
    total = agree + len(ours_only) + len(theirs_only)
    if not total:
        return []
    found = [
        Finding(
            f"Pauses in the sound: of {total} networks and MU lengths that the thesis reports and "
            f"this run measured, the thesis policy agrees with it in {agree} on whether there "
            f"are pauses (fewer than {CLEAN_PER_MIN:.0f} a minute count as none)."
        )
    ]
    if ours_only:
        found.append(_listed("Pauses where the thesis has none: ", ours_only))
    if theirs_only:
        found.append(_listed("No pauses where the thesis has some: ", theirs_only))
    return found + _clean_from(here)


def _only_windows(clients: dict[str, dict[int, thesis.Pauses]]) -> dict[int, thesis.Pauses]:
    """Give the lengths that were tried with the later clients alone (500 ms on the Internet)."""
    first = next(iter(clients.values()))
    return {
        mu_ms: words
        for by_mu in clients.values()
        for mu_ms, words in by_mu.items()
        if mu_ms not in first
    }


def _clean_from(here: Entries) -> list[Finding]:
    """For each profile: from which MU length on there are no pauses."""
    parts: list[str] = []
    about: Entries = ()
    for profile in pick.profiles(here):
        rates = {
            mu_ms: rate
            for mu_ms in MUS_MS
            if (rate := pauses_per_min(of_mu(here, profile, mu_ms))) is not None
        }
        if len(rates) < 2:
            continue
        bad = [mu_ms for mu_ms, rate in rates.items() if rate >= CLEAN_PER_MIN]
        clean = [mu_ms for mu_ms in rates if mu_ms > max(bad, default=0)]
        parts.append(f"{profile} {f'from {min(clean)} ms' if clean else 'at no length'}")
        about += pick.on(here, profile)
    if not parts:
        return []
    return [Finding("The thesis policy’s sound has no pauses on " + ", ".join(parts) + ".", about)]


def _listed(start: str, parts: list[tuple[str, Entries]]) -> Finding:
    about = tuple(entry for _, entries in parts for entry in entries)
    return Finding(start + ", ".join(text for text, _ in parts) + ".", about)
