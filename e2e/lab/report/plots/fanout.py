"""E5: what more viewers cost the server, and the operator."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from e2e.lab.report import pick, series
from e2e.lab.report.blocks import Plot
from e2e.lab.report.drawing import data_uri, legend, look, panel
from e2e.lab.report.measures import MEASURES
from e2e.lab.report.shown import spread

if TYPE_CHECKING:
    from e2e.lab.report.pick import Entries

PANELS: Final = (
    ("server_cpu_share", 100.0, "server, % of one core", "server"),
    ("picture_age_p95_ms", 1.0, "picture’s age, p95, ms", "figures.picture_age_ms"),
    (
        "command_round_trip_p95_ms",
        1.0,
        "command’s round trip, p95, ms",
        "figures.command_round_trip_ms",
    ),
)


def by_viewers(entries: Entries) -> tuple[Plot, ...]:
    """Draw one panel for each thing that may grow with the viewers, for each profile."""
    plots = []
    for profile in pick.profiles(entries):
        here = pick.on(entries, profile)
        for name, factor, label, drawn_from in PANELS:
            with panel() as (drawing, axes):
                is_drawn = False
                for system in pick.systems(here):
                    found = [
                        (viewers, summed)
                        for viewers in sorted({entry.cell.viewers for entry in here})
                        if (
                            summed := spread(
                                tuple(
                                    entry
                                    for entry in here
                                    if (entry.cell.system, entry.cell.viewers) == (system, viewers)
                                ),
                                MEASURES[name],
                            )
                        )
                        and max(-summed.least, summed.most) < series.MOST
                    ]
                    if not found:
                        continue
                    is_drawn = True
                    axes.errorbar(
                        [viewers for viewers, _ in found],
                        [one.median * factor for _, one in found],
                        yerr=[
                            [(one.median - one.least) * factor for _, one in found],
                            [(one.most - one.median) * factor for _, one in found],
                        ],
                        marker="o",
                        markersize=4,
                        capsize=2,
                        **look(system),
                    )
                if not is_drawn:
                    continue
                axes.set_ylim(bottom=0)
                axes.set_xlim(left=0)
                axes.set_xlabel("viewers")
                axes.set_ylabel(label)
                axes.set_title(profile)
                legend(drawing)
                plots.append(
                    Plot(
                        data_uri(drawing),
                        f"{label} against the number of viewers on {profile}",
                        f"{profile}: {label}, over the number of viewers.",
                        here,
                        drawn_from,
                    )
                )
    return tuple(plots)
