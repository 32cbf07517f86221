"""E3, after 5.4: what is left of picture and sound on thin links; with 3.5's predictions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from e2e.lab.plan import NARROW
from e2e.lab.report import pick, tables, thesis
from e2e.lab.report.blocks import Finding, Section
from e2e.lab.report.measures import MEASURES
from e2e.lab.report.plots import over_time
from e2e.lab.report.shown import spread

if TYPE_CHECKING:
    from e2e.lab.report.pick import Entries

PREDICTED: Final = ("isdn-64k", "dual-modem")


def section(cells: Entries) -> Section:
    here = pick.where(pick.plain(cells), lambda one: one.profile in NARROW)
    title, source = "E3 · Thin links", "thesis 5.4, bandwidth stress test, and 3.5, predictions"
    if not here:
        return Section("e3", title, source, ("This run has no cell of this experiment.",))
    columns = (
        tables.of("pictures_per_s"),
        tables.of("picture_age_p50_ms", "picture_age_p95_ms", head="picture’s age"),
        tables.of("late_pictures_per_s"),
        tables.of("longest_freeze_ms"),
        tables.pauses("tone"),
        tables.pauses("concealed"),
        tables.bytes_per_s("received"),
        tables.of("fail_safe_s"),
        tables.of("picture_drift_ms_per_min"),
    )
    least = thesis.LEAST_BANDWIDTH
    return Section(
        "e3",
        title,
        source,
        (
            tables.by_profile(
                "What arrives, by network and system",
                here,
                columns,
                "In 2004 the client timed a picture’s transfer, from asking to having it; here it "
                "is its age, from capture to the screen. Late: in 2004 a transfer of more than "
                "100 ms, here more than 100 ms older than the cell’s youngest picture.",
                f"The thesis’s WAX needs {least.text} ({least.where}).",
                *_whole_fail_safe(here),
            ),
            over_time.ages(here, "picture"),
        ),
        tuple(findings(here)),
    )


def _whole_fail_safe(here: Entries) -> tuple[str, ...]:
    """Say where the fail-safe time is not of the measured time, as in runs of older versions."""
    is_whole = any(
        MEASURES["fail_safe_s"].of(entry.result) and "counted_from_ms" not in entry.result.told
        for entry in here
    )
    if not is_whole:
        return ()
    return (
        "The time in fail-safe mode is counted in this run from when the page was opened, start-up "
        "included, not from where the other figures begin.",
    )


def findings(here: Entries) -> list[Finding]:
    """Hold the thesis policy's frame rates against what was measured or predicted in 2004."""
    rate = MEASURES["pictures_per_s"]
    parts: list[str] = []
    about: Entries = ()
    for profile in pick.profiles(here):
        entries = pick.on(here, profile, "thesis")
        summed = spread(entries, rate)
        if summed is None or profile not in thesis.FRAMES_PER_S:
            continue
        least, most = thesis.FRAMES_PER_S[profile]
        span = f"{least:.2g}" if least == most else f"{least:.2g} to {most:.2g}"
        # A twentieth off is still the same: a picture more or less in two seconds of ten.
        below, above = summed.median < least * 0.95, summed.median > most * 1.05
        verdict = "fewer than" if below else "more than" if above else "as"
        in_2004 = "its prediction" if profile in PREDICTED else "the thesis"
        parts.append(f"{profile} {rate.text(summed.median)} ({verdict} {in_2004}: {span})")
        about += entries
    if not parts:
        return []
    return [Finding("Pictures a second of our thesis policy: " + ", ".join(parts) + ".", about)]
