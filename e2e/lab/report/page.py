"""Put the page together; every text from the run is escaped."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from e2e.lab.client2004.thesis import CONTRADICTIONS
from e2e.lab.report import appendix, pick, thesis
from e2e.lab.report.blocks import Folded, Table
from e2e.lab.report.head import head
from e2e.lab.report.sections import browsers, changes, fanout, goals, inter, intra, stress, systems

if TYPE_CHECKING:
    from e2e.lab.report.blocks import Block
    from e2e.lab.results import Run

FOLDER: Final = Path(__file__).parent / "templates"


def html(run: Run) -> str:
    """Make the whole page, whatever the run has or lacks."""
    cells = pick.entries(run)
    environment = Environment(
        loader=FileSystemLoader(FOLDER),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.tests["table"] = lambda block: isinstance(block, Table)
    environment.tests["folded"] = lambda block: isinstance(block, Folded)
    environment.tests["plots"] = _is_plots
    return environment.get_template("page.html").render(
        run=run,
        head=head(run, cells),
        sections=(
            *goals.sections(cells),
            intra.section(run, cells),
            inter.section(cells),
            stress.section(cells),
            browsers.section(cells),
            fanout.section(cells),
            changes.section(cells),
            systems.section(cells),
        ),
        listed=appendix.listed(cells),
        contradictions=CONTRADICTIONS,
        half_a_second=thesis.HALF_A_SECOND,
    )


def _is_plots(block: Block) -> bool:
    return isinstance(block, tuple)
