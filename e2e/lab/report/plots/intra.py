"""After Figures 5.31–5.33 and 5.44: pauses fall as the MU grows; and when they came."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal

from matplotlib.ticker import ScalarFormatter

from e2e.lab.client2004.table import MU_LENGTHS_MS
from e2e.lab.report import pick, series, thesis
from e2e.lab.report.blocks import Plot
from e2e.lab.report.drawing import GREY, MU_COLOURS, data_uri, legend, panel
from e2e.lab.report.measures import MEASURES
from e2e.lab.report.names import COLOURS
from e2e.lab.report.shown import spread

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from e2e.lab.report.blocks import Entry
    from e2e.lab.report.model2004 import Rows
    from e2e.lab.report.pick import Entries

POINTS: Final = 800


def falling(here: Entries, model: Rows) -> tuple[Plot, ...]:
    """Draw one panel for each profile: pauses a minute over the length of the MU."""
    plots = []
    for profile in pick.profiles(here):
        cells = pick.on(here, profile)
        with panel() as (drawing, axes):
            for number, (client, by_mu) in enumerate(thesis.AUDIO.get(profile, {}).items()):
                _thesis(axes, by_mu, number, client)
            for scene, style in zip(thesis.SCENES.get(profile, {}), (":", "-."), strict=False):
                rows = [row for mu_ms in MU_LENGTHS_MS if (row := model.get((scene, mu_ms)))]
                axes.plot(
                    [row.mu_ms for row in rows],
                    [row.pauses_per_s * 60 for row in rows],
                    color=GREY,
                    linestyle=style,
                    marker=".",
                    label=f"model: {scene}",
                )
            drawn = [_ours(axes, cells, kind) for kind in ("tone", "concealed")]
            if not any(drawn):
                continue
            axes.set_yscale("symlog", linthresh=1)
            axes.set_ylim(-0.3, 1500)
            axes.yaxis.set_major_formatter(ScalarFormatter())
            axes.set_xticks(MU_LENGTHS_MS)
            axes.set_xlim(60, 540)
            axes.set_xlabel("audio MU, ms")
            axes.set_ylabel("pauses per minute")
            axes.set_title(profile)
            legend(drawing, 2)
            plots.append(
                Plot(
                    data_uri(drawing),
                    f"Pauses per minute against the audio MU on {profile}",
                    f"{profile}: pauses over the MU, after Figure "
                    f"{thesis.DELAY_FIGURES.get(profile, '5.44')}."
                    + (
                        " Grey bars: what the thesis says, from least to most."
                        if profile in thesis.AUDIO
                        else ""
                    ),
                    cells,
                    "figures.tone_pauses, figures.concealed_pauses",
                )
            )
    return tuple(plots)


def _thesis(axes: Axes, by_mu: dict[int, thesis.Pauses], number: int, client: str) -> None:
    told = {mu_ms: said.per_min for mu_ms, said in by_mu.items() if said.per_min is not None}
    if not told:
        return
    xs = [mu_ms - 12 - 9 * number for mu_ms in told]
    lows = [low for low, _ in told.values()]
    highs = [high for _, high in told.values()]
    axes.vlines(xs, lows, highs, color="#BDBDBD", linewidth=5 - number)
    axes.plot(
        xs,
        highs,
        linestyle="",
        marker="_sd^"[number % 4],
        markersize=6 - number,
        color=GREY,
        label="thesis" + (f": {client}" if client else ""),
    )


def _ours(axes: Axes, cells: Entries, kind: Literal["tone", "concealed"]) -> bool:
    found = []
    for mu_ms in MU_LENGTHS_MS:
        here = tuple(entry for entry in cells if pick.mu_ms(entry.cell) == mu_ms)
        summed = spread(here, MEASURES[f"{kind}_pauses_per_min"])
        if summed is not None and summed.most < series.MOST:
            found.append((mu_ms, summed))
    if not found:
        return False
    middles = [one.median for _, one in found]
    axes.errorbar(
        [mu_ms + (4 if kind == "tone" else 9) for mu_ms, _ in found],
        middles,
        yerr=[
            [one.median - one.least for _, one in found],
            [one.most - one.median for _, one in found],
        ],
        color=COLOURS["thesis"],
        linestyle="-" if kind == "tone" else "--",
        marker="o" if kind == "tone" else "x",
        markersize=4,
        capsize=2,
        label="ours: tone gaps" if kind == "tone" else "ours: concealments",
    )
    return True


def over_time(here: Entries) -> tuple[Plot, ...]:
    """Draw when each pause came and how long it was, one panel for each profile."""
    plots = []
    for profile in pick.profiles(here):
        first = [
            entry
            for mu_ms in MU_LENGTHS_MS
            if (
                entry := pick.first_ok(
                    pick.where(
                        pick.on(here, profile),
                        lambda cell, mu_ms=mu_ms: pick.mu_ms(cell) == mu_ms,  # type: ignore[misc]  # no type for a default
                    )
                )
            )
        ]
        if not first or (profile not in thesis.DELAY_FIGURES and not any(map(_pauses, first))):
            continue
        with panel(2.2) as (drawing, axes):
            for lane, entry in enumerate(first):
                pauses = _pauses(entry)
                axes.broken_barh(
                    # A gap of 30 ms would be too thin to be seen.
                    [(at_s, max(length_ms / 1000, 0.04)) for at_s, length_ms in pauses],
                    (lane - 0.35, 0.7),
                    color=MU_COLOURS.get(pick.mu_ms(entry.cell), GREY),
                )
            axes.set_yticks(
                range(len(first)),
                [f"{pick.mu_ms(one.cell)} ms: {len(_pauses(one)) or 'none'}" for one in first],
            )
            axes.set_ylim(len(first) - 0.4, -0.6)
            axes.set_xlim(0, max(one.cell.seconds for one in first))
            axes.set_xlabel("s since the measuring began")
            axes.set_ylabel("audio MU: tone gaps")
            axes.set_title(profile)
            figure = thesis.DELAY_FIGURES.get(profile)
            plots.append(
                Plot(
                    data_uri(drawing),
                    f"When the sound paused on {profile}, and for how long",
                    f"{profile}: each gap of the tone, when and how long"
                    + (f" (Figure {figure} has the delays over the MUs)." if figure else "."),
                    tuple(first),
                    "figures.tone_pauses",
                )
            )
    return tuple(plots)


def one_cell(here: Entries) -> tuple[Plot, ...]:
    """Draw the tone itself in the cell with the most gaps, the gaps shaded."""
    heard = [
        entry
        for entry in here
        if entry.result.readings is not None and entry.result.readings.sound.start_ms
    ]
    entry = max(heard, key=lambda one: len(_pauses(one)), default=None)
    if entry is None or entry.result.readings is None or entry.result.figures is None:
        return ()
    sound, zero_ms = entry.result.readings.sound, entry.result.figures.from_ms
    tone = [
        ((start_ms - zero_ms) / 1000, value)
        for start_ms, value in zip(sound.start_ms, sound.tone, strict=False)
    ]
    with panel() as (drawing, axes):
        points = series.thinned(series.sane(tone), POINTS)
        axes.plot(
            [at_s for at_s, _ in points],
            [value for _, value in points],
            color=COLOURS["thesis"],
            linewidth=0.7,
        )
        for at_s, length_ms in _pauses(entry):
            axes.axvspan(at_s, at_s + length_ms / 1000, color="#BBBBBB", alpha=0.6, linewidth=0)
        axes.set_xlim(0, entry.cell.seconds)
        axes.set_xlabel("s since the measuring began")
        axes.set_ylabel("amplitude of the tone")
        axes.set_title(f"{entry.cell.profile}, audio MU {pick.mu_ms(entry.cell)} ms")
        return (
            Plot(
                data_uri(drawing),
                f"The tone as it was played in {entry.key}",
                f"The tone as played in the cell with the most gaps, {entry.key}; gaps grey.",
                (entry,),
                "readings.sound.tone",
            ),
        )


def _pauses(entry: Entry) -> list[tuple[float, float]]:
    """Tone gaps as (s since the measuring began, ms)."""
    figures = entry.result.figures
    if figures is None:
        return []
    pauses = figures.tone_pauses
    return series.sane(
        [
            ((at_ms - figures.from_ms) / 1000, length_ms)
            for at_ms, length_ms in zip(pauses.at_ms, pauses.length_ms, strict=False)
        ]
    )
