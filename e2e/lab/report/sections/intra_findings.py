"""What E1 comes to in sentences: who has pauses where, and where 2004 had it easier."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from e2e.lab.client2004.table import CLEAN_PER_S, MU_LENGTHS_MS
from e2e.lab.report import model2004, pick, thesis
from e2e.lab.report.blocks import Finding
from e2e.lab.report.measures import HEARD_MS, MEASURES, heard_min
from e2e.lab.report.names import loses
from e2e.lab.report.shown import problem, spread

if TYPE_CHECKING:
    from e2e.lab.report.model2004 import Rows
    from e2e.lab.report.pick import Entries

CLEAN_PER_MIN: Final = 60 * CLEAN_PER_S
"""Fewer than one in 20 s count as none, as for the model."""


def of_mu(entries: Entries, profile: str, mu_ms: int) -> Entries:
    return pick.where(entries, lambda cell: cell.profile == profile and pick.mu_ms(cell) == mu_ms)


def pauses_per_min(entries: Entries) -> float | None:
    """Tone gaps that 2004's client would not bridge, or concealments, whichever are more."""
    both = [
        summed.median
        for name in ("heard_tone_pauses_per_min", "concealed_pauses_per_min")
        if (summed := spread(entries, MEASURES[name]))
    ]
    return max(both, default=None)


def findings(here: Entries, model: Rows) -> list[Finding]:
    """Say where the policy has pauses and the thesis none, and the other way round."""
    agree = 0
    judged: Entries = ()
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
            judged += entries
            has = ours >= CLEAN_PER_MIN
            if has == (not words.none):
                agree += 1
            elif has:
                ours_only.append((f"{profile} at {mu_ms} ms ({ours:.0f} a minute)", entries))
            else:
                theirs_only.append((f"{profile} at {mu_ms} ms ({words.text})", entries))
    total = agree + len(ours_only) + len(theirs_only)
    found = []
    if total:
        text = (
            f"Pauses in the sound: of {total} networks and MU lengths that the thesis reports and "
            f"this run measured, the thesis policy agrees with it in {agree} on whether there "
            f"are pauses ({_what_is_none(judged)})."
        )
        found.append(Finding(text))
    if ours_only:
        found.append(_listed("Pauses where the thesis has none: ", ours_only))
    if theirs_only:
        found.append(_listed("No pauses where the thesis has some: ", theirs_only))
    return [*found, *_clean_from(here), *lossy(here), *_of_model(model)]


def lossy(here: Entries) -> list[Finding]:
    """Say where the baseline has it harder than the thesis had."""
    profiles = [
        name for name in pick.profiles(here) if loses(name) and problem(pick.on(here, name)) is None
    ]
    if not profiles:
        return []
    about = pick.where(here, lambda cell: cell.profile in profiles)
    return [
        Finding(
            f"Where packets are lost ({', '.join(profiles)}) the baseline is worse off than 2004’s "
            "WAX would be: TCP sent again what was lost, so that its sound came whole, if late. "
            "The baseline’s sound is RTP, which is not sent again: a lost packet is a gap of up to "
            "100 ms, and when it is the last of its MU the sound waits for a second or longer, "
            "MUs are skipped and fail-safe mode begins. What it does there is not the thesis’s.",
            about,
        )
    ]


def _what_is_none(judged: Entries) -> str:
    """Say what counts as no pauses in cells of this length."""
    text = (
        f"gaps of at most {HEARD_MS:.0f} ms, which 2004’s client bridged, do not count, and fewer "
        f"than {CLEAN_PER_MIN:.0f} a minute are none"
    )
    minutes = max(
        (heard_min(one.result.figures) for one in judged if one.result.figures), default=0.0
    )
    if not 0 < minutes * CLEAN_PER_MIN <= 1:
        return text
    return f"{text}: in the {60 * minutes:.0f} s that were judged of each cell, not one"


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
            for mu_ms in MU_LENGTHS_MS
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


def _of_model(model: Rows) -> list[Finding]:
    """Say how far the model of 2004's client is the thesis's."""
    agree, total = model2004.agreement(model)
    if not total:
        return []
    text = (
        f"The model of 2004’s client agrees with the thesis in {agree} of {total} connections and "
        "MU lengths on whether there are pauses"
    )
    figures = [one.where for one in model2004.differences(model) if one.is_figure]
    if figures:
        text += f"; it does not reproduce what is said of {' and '.join(figures)}"
    return [Finding(text + ".")]


def _listed(start: str, parts: list[tuple[str, Entries]]) -> Finding:
    about = tuple(entry for _, entries in parts for entry in entries)
    return Finding(start + ", ".join(text for text, _ in parts) + ".", about)
