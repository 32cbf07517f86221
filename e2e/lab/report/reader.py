"""A page as its reader has it, for tests."""

from __future__ import annotations

from html.parser import HTMLParser
from typing import TYPE_CHECKING, Any

from e2e.lab.cell import Cell
from e2e.lab.report.page import html

if TYPE_CHECKING:
    from e2e.lab.results import Run


class Page(HTMLParser):
    """What a reader has: the ids, the links, and each table cell with what stands behind it."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.ids: list[str] = []
        self.links: list[str] = []
        self.cells: list[tuple[str, str]] = []
        self.images: list[dict[str, str | None]] = []
        self.words = ""
        self.tags: set[str] = set()
        self._in_td = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.tags.add(tag)
        if (one := given.get("id")) is not None:
            self.ids.append(one)
        if (link := given.get("href")) is not None:
            self.links.append(link)
        if tag == "img":
            self.images.append(given)
        if tag == "td":
            self._in_td = True
        elif self._in_td and tag in ("a", "span"):
            self.cells.append(("", given.get("title") or ""))

    def handle_endtag(self, tag: str) -> None:
        if tag == "td":
            self._in_td = False

    def handle_data(self, data: str) -> None:
        self.words += data
        if self._in_td and self.cells:
            text, title = self.cells[-1]
            self.cells[-1] = (text + data, title)

    def behind(self, text: str) -> list[str]:
        """Give what stands behind each table cell that reads so."""
        return [title for shown, title in self.cells if " ".join(shown.split()) == text]


def page_of(of: Run) -> Page:
    """Make the page of a run and read it."""
    return Page(html(of))


def a_cell(
    experiment: str = "E2", profile: str = "lan", system: str = "stock", **more: Any
) -> Cell:
    """Name a cell by what matters to a test."""
    return Cell.model_validate(
        {"experiment": experiment, "profile": profile, "system": system, **more}
    )
