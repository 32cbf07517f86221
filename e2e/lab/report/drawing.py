"""How a plot looks and how it gets into the page: small panels of one width, as data in the page.

Many small panels instead of one wide plot, so that they are as legible on a phone as beside one
another on a desktop.
"""

from __future__ import annotations

import base64
import io
import re
import warnings
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import quote

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Drawing
from matplotlib.ticker import LogLocator, NullLocator, ScalarFormatter

from e2e.lab.report.names import COLOURS, SYSTEMS

if TYPE_CHECKING:
    from collections.abc import Iterator

    from matplotlib.axes import Axes

    from e2e.lab.cell import SystemName

WIDTH_INCHES: Final = 4.6
SVG_AT_MOST_BYTES: Final = 40_000
"""Of a longer one, as of a dense series, the PNG may be shorter."""
_DECIMALS: Final = re.compile(r"(\d\.\d\d)\d{2,}")
"""Points of 1/72 inch need no more than two; numbers of three, as scales have, are left alone."""
_SAFE: Final = " !$&'()*+,-./:;=?@[]^_`{|}~<>"
"""What may stand in a quoted data URI as it is: no quote, no percent, no hash, no line break."""
MU_COLOURS: Final = {100: "#440154", 200: "#3B528B", 300: "#21918C", 400: "#5EC962", 500: "#C8A800"}
GREY: Final = "#8A8A8A"

STYLE: Final[dict[Any, Any]] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["Helvetica", "Arial", "DejaVu Sans"],
    "font.size": 8.5,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#777777",
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#E4E4E4",
    "grid.linewidth": 0.7,
    "xtick.color": "#555555",
    "ytick.color": "#555555",
    "lines.linewidth": 1.3,
    "legend.frameon": False,
    "legend.fontsize": 7.5,
    "figure.facecolor": "white",
    "svg.hashsalt": "lab",
    "svg.fonttype": "none",
    # What systems and profiles are called is text, never a formula.
    "text.parse_math": False,
}


@contextmanager
def panel(height_inches: float = 2.7) -> Iterator[tuple[Drawing, Axes]]:
    """Give a drawing with one pair of axes in the page's style."""
    # A name may hold a letter that no font at hand has; a box in its place will do.
    with mpl.rc_context(STYLE), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        drawing = Drawing(figsize=(WIDTH_INCHES, height_inches), layout="constrained")
        yield drawing, drawing.add_subplot()


def look(system: SystemName) -> dict[str, Any]:
    """Give the same colour, line and name to a system wherever it is drawn."""
    return {
        "color": COLOURS[system],
        "linestyle": "--" if system in ("stock", "livekit") else "-",
        "label": SYSTEMS[system],
    }


def legend(drawing: Drawing, ncols: int = 3) -> None:
    """Name the lines below the axes, where they hide nothing."""
    drawing.legend(loc="outside lower center", ncols=ncols)


def log_ages(axes: Axes) -> None:
    """Make the ordinate logarithmic, with plain numbers at 1, 2 and 5."""
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter(ScalarFormatter())
    axes.yaxis.set_minor_locator(NullLocator())


def data_uri(drawing: Drawing) -> str:
    """Make the image: SVG, or PNG where that is shorter; the same bytes for the same drawing."""
    buffer = io.BytesIO()
    drawing.savefig(buffer, format="svg", metadata={"Date": None})
    svg = _DECIMALS.sub(r"\1", buffer.getvalue().decode())
    uri = "data:image/svg+xml," + quote(svg, safe=_SAFE)
    if len(uri) <= SVG_AT_MOST_BYTES:
        return uri
    buffer = io.BytesIO()
    FigureCanvasAgg(drawing)
    drawing.savefig(buffer, format="png", dpi=140, metadata={"Software": None})
    png = "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode()
    return min(uri, png, key=len)
