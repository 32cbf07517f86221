"""What a page is made of: sections of tables, plots and paragraphs; and the cells they quote."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from e2e.lab.cell import Cell
    from e2e.lab.results import CellResult

State = Literal["ok", "failed", "not run", "nothing", "said"]


@dataclass(frozen=True, slots=True)
class Entry:
    """One cell of the run and where it stands in the run's JSON."""

    index: int
    result: CellResult

    @property
    def cell(self) -> Cell:
        return self.result.cell

    @property
    def key(self) -> str:
        return self.result.cell.key

    @property
    def path(self) -> str:
        return f"cells[{self.index}]"

    @property
    def anchor(self) -> str:
        return f"cell-{self.index}"

    @property
    def problem(self) -> str:
        return self.result.problem or "no reason was given"


@dataclass(frozen=True, slots=True)
class Line:
    """A text, what stands behind it (shown on hover), and where the page says more.

    `is_problem`: it names a repetition that is missing. `spread`, the least and the greatest, and
    `unit` are written after the text.
    """

    text: str
    title: str = ""
    anchor: str | None = None
    small: bool = False
    is_problem: bool = False
    spread: str = ""
    unit: str = ""


@dataclass(frozen=True, slots=True)
class Shown:
    """One cell of a table."""

    state: State
    lines: tuple[Line, ...]


@dataclass(frozen=True, slots=True)
class Row:
    """`whole`, where given, takes the place of all the cells: a failure's sentence, a heading."""

    head: Line
    shown: tuple[Shown, ...] = ()
    whole: Shown | None = None
    kind: Literal["", "group", "thesis"] = ""


@dataclass(frozen=True, slots=True)
class Table:
    title: str
    heads: tuple[Line, ...]
    """The first is above the rows' heads."""
    rows: tuple[Row, ...]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Plot:
    """`sources` are the cells whose raw series are drawn, `drawn_from` where those are."""

    uri: str
    alt: str
    caption: str
    sources: tuple[Entry, ...]
    drawn_from: str


@dataclass(frozen=True, slots=True)
class Folded:
    """A table that opens when asked for."""

    title: str
    table: Table
    is_open: bool = False


@dataclass(frozen=True, slots=True)
class Finding:
    """One sentence of the summary, computed, with the cells it is about."""

    text: str
    entries: tuple[Entry, ...] = ()


Block = Table | Folded | tuple[Plot, ...] | str


@dataclass(frozen=True, slots=True)
class Section:
    anchor: str
    title: str
    source: str
    """The place in the thesis that it repeats, or why it is here."""
    blocks: tuple[Block, ...]
    findings: tuple[Finding, ...] = ()
