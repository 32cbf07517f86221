"""The plots: small panels of one width, as SVG in the page, legible on a phone too."""

from __future__ import annotations

import io
import re
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import quote

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator, ScalarFormatter
from tests.baseline.client2004 import table as model
from tests.baseline.client2004.scenes import SCENES

from e2e.delay import series, thesis
from e2e.delay.found import median, on, profiles, spread, systems, where
from e2e.delay.names import COLOURS, PEERS, SYSTEMS, changes_s

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from matplotlib.axes import Axes

    from e2e.delay.cell import Cell
    from e2e.delay.found import Found
    from e2e.delay.results import CellResult
    from e2e.delay.series import Series

    Read = Callable[[Cell], CellResult | None]
    """Give all that was read of a cell; None where there is nothing."""

POINTS: Final = 300
EARLY_MS: Final = -45.0
LATE_MS: Final = 125.0
"""ITU-R BT.1359: from here on people notice that the sound is early, or late."""
_DECIMALS: Final = re.compile(r"(\d\.\d\d)\d{2,}")
"""Points of 1/72 inch need no more than two; numbers of three, as scales have, are left alone."""
_SAFE: Final = " !$&'()*+,-./:;=?@[]^_`{|}~<>"
"""What may stand in a quoted data URI as it is: no quote, no percent, no hash, no line break."""
_STYLE: Final[dict[Any, Any]] = {
    "font.sans-serif": ["Helvetica", "Arial", "DejaVu Sans"],
    "font.size": 8.5,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#E4E4E4",
    "lines.linewidth": 1.3,
    "legend.frameon": False,
    "legend.fontsize": 7.5,
    "svg.hashsalt": "lab",
    "svg.fonttype": "none",
    # What systems and profiles are called is text, never a formula.
    "text.parse_math": False,
}


@dataclass(frozen=True, slots=True)
class Drawn:
    """An image as a data URI, with what it shows."""

    uri: str
    caption: str


class Panel:
    """A drawing with one pair of axes; `drawn` is empty when nothing was plotted on it."""

    def __init__(self, title: str, x: str, y: str) -> None:
        self._figure = Figure(figsize=(4.6, 2.7), layout="constrained")
        self.axes: Axes = self._figure.add_subplot()
        self.axes.set_title(title)
        self.axes.set_xlabel(x)
        self.axes.set_ylabel(y)
        self._caption = f"{title}: {y}, over {x}."

    def drawn(self, more: str = "") -> list[Drawn]:
        if not self.axes.get_legend_handles_labels()[0]:
            return []
        self._figure.legend(loc="outside lower center", ncols=3)
        buffer = io.BytesIO()
        self._figure.savefig(buffer, format="svg", metadata={"Date": None})
        svg = _DECIMALS.sub(r"\1", buffer.getvalue().decode())
        uri = f"data:image/svg+xml,{quote(svg, safe=_SAFE)}"
        return [Drawn(uri, f"{self._caption} {more}".strip())]


@contextmanager
def _panel(title: str, x: str, y: str) -> Iterator[Panel]:
    with mpl.rc_context(_STYLE):
        yield Panel(title, x, y)


def over_mu(cells: Sequence[Found], read: Read) -> list[Drawn]:
    """Draw how pauses fall as the MU grows, after Figures 5.31 to 5.33 and 5.44."""
    found = []
    for profile in profiles(where(cells, lambda cell: cell.system == "thesis")):
        with _panel(profile, "audio MU, ms", "pauses per minute") as panel:
            axes = panel.axes
            for client, by_mu in thesis.AUDIO.get(profile, {}).items():
                told = {mu_ms: said.per_min for mu_ms, said in by_mu.items() if said.per_min}
                axes.vlines(
                    [mu_ms - 12 for mu_ms in told],
                    [least for least, _ in told.values()],
                    [most for _, most in told.values()],
                    color="#BDBDBD",
                    linewidth=5,
                    label=f"thesis{client and ': '}{client}",
                )
            for scene in SCENES:
                if scene.profile == profile:
                    heard = [model.hear(scene, mu_ms) for mu_ms in model.MU_LENGTHS_MS]
                    rates = [60 * one.pauses_per_s for one in heard]
                    label = f"model: {scene.name}"
                    axes.plot(model.MU_LENGTHS_MS, rates, ":.", color="#8A8A8A", label=label)
            for kind, style in (("tone", "-o"), ("concealed", "--x")):
                points = [
                    (mu_ms, value)
                    for mu_ms in model.MU_LENGTHS_MS
                    if (value := median(_of_mu(cells, profile, mu_ms), f"{kind}_pauses_per_min"))
                    is not None
                ]
                if points:
                    label = f"thesis policy: {kind}"
                    axes.plot(*zip(*points, strict=True), style, color="#D55E00", label=label)
            axes.set_yscale("symlog", linthresh=1)
            axes.yaxis.set_major_formatter(ScalarFormatter())
            axes.set_xticks(model.MU_LENGTHS_MS)
            found += panel.drawn("Grey bars: what the thesis says, from least to most.")
    return found


def over_viewers(cells: Sequence[Found], read: Read) -> list[Drawn]:
    """Draw what more viewers cost the server, and the first of them."""
    found = []
    for name, label in (
        ("server_cpu", "server, % of one core"),
        ("picture_age_p95_ms", "first viewer’s picture, p95, ms"),
    ):
        for profile in profiles(cells):
            with _panel(profile, "viewers", label) as panel:
                for system in systems(on(cells, profile)):
                    here = on(cells, profile, system)
                    points = [
                        (viewers, one)
                        for viewers in sorted({one.cell.viewers for one in here})
                        if (one := spread(_of_crowd(here, viewers), name))
                    ]
                    if points:
                        panel.axes.errorbar(
                            [viewers for viewers, _ in points],
                            [one.median for _, one in points],
                            yerr=[
                                [one.median - one.min for _, one in points],
                                [one.max - one.median for _, one in points],
                            ],
                            marker="o",
                            markersize=4,
                            capsize=2,
                            **_look(system),
                        )
                panel.axes.set_ylim(bottom=0)
                found += panel.drawn()
    return found


def skew_over_time(cells: Sequence[Found], read: Read) -> list[Drawn]:
    """Draw the skew of each system, burst by burst."""
    found = []
    for profile in profiles(cells):
        with _panel(profile, "s since the measuring began", "skew, ms") as panel:
            panel.axes.axhspan(EARLY_MS, LATE_MS, color="#F0F0F0", linewidth=0)
            _lines(panel.axes, on(cells, profile), read, lambda one: series.skews(one.readings))
            found += panel.drawn("Grey: what people do not notice (ITU-R BT.1359).")
    return found


def picture_over_time(cells: Sequence[Found], read: Read) -> list[Drawn]:
    """Draw the age of the picture; where the link changes, the changes are marked."""
    found = []
    for profile in profiles(cells):
        changes = changes_s(profile)
        since = "the changes began to count" if changes else "the measuring began"
        with _panel(profile, f"s since {since}", "picture’s age, ms") as panel:
            axes = panel.axes
            _lines(
                axes,
                on(cells, profile),
                read,
                lambda result: series.standing(series.picture_ages(result.readings)),
            )
            axes.set_yscale("log")
            axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            axes.yaxis.set_major_formatter(ScalarFormatter())
            axes.yaxis.set_minor_locator(NullLocator())
            for number, (at_s, words) in enumerate(changes):
                axes.axvline(at_s, color="#333333", linewidth=0.9, linestyle=":")
                place = axes.get_xaxis_transform()
                axes.text(at_s, 1 - 0.08 * (number % 3), f" {words}", fontsize=6.5, transform=place)
            found += panel.drawn("It grows while one picture stands.")
    return found


def _lines(
    axes: Axes, cells: Sequence[Found], read: Read, of: Callable[[CellResult], Series]
) -> None:
    """Draw of each system the first cell that was measured."""
    for system in systems(cells):
        first = next((one for one in cells if one.cell.system == system and one.values), None)
        result = None if first is None else read(first.cell)
        if result is None:
            continue
        zero_ms = result.told.get("changes_began_ms") if changes_s(result.cell.profile) else None
        zero_ms = zero_ms if isinstance(zero_ms, float) else result.figures.from_ms
        points = [((at_ms - zero_ms) / 1000, value) for at_ms, value in of(result)]
        if points:
            shown = series.thinned(points, POINTS)
            axes.plot([at for at, _ in shown], [value for _, value in shown], **_look(system))


def _look(system: Any) -> dict[str, Any]:
    """Give the same colour, line and name to a system wherever it is drawn."""
    line = "--" if system in PEERS else "-"
    return {"color": COLOURS[system], "linestyle": line, "label": SYSTEMS[system]}


def _of_mu(cells: Sequence[Found], profile: str, mu_ms: int) -> list[Found]:
    return where(on(cells, profile, "thesis"), lambda cell: cell.mu_ms == mu_ms)


def _of_crowd(cells: Sequence[Found], viewers: int) -> list[Found]:
    return where(cells, lambda cell: cell.viewers == viewers)
