"""Renders the published figures as tables: all on a page of their own, a few in the README."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from e2e.measure.errors import MeasureError
from e2e.measure.headline import rows
from e2e.measure.published import everything
from e2e.measure.runner import SUITES
from e2e.measure.table import to_headline, to_markdown

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from e2e.measure.published import Published

_BLOCK: Final = re.compile(r"(<!-- figures: headline -->\n).*?(<!-- /figures -->)", re.DOTALL)
_ABOVE: Final = """\
# Figures

Rendered by `make measure` from the files beside this one; never typed. [How they are
measured](../README.md). What is judged is bold, and *missed* where it misses its goal.
"""


def render(folder: Path, readme: Path) -> None:
    """Write both; raises `MeasureError`."""
    published = everything(folder)
    (folder / "README.md").write_text(page(published), encoding="utf-8")
    text = with_headline(readme.read_text(encoding="utf-8"), published)
    readme.write_text(text, encoding="utf-8")


def page(published: Sequence[Published]) -> str:
    """Render every table, in the order of the suites."""
    order = list(SUITES)
    ordered = sorted(
        published, key=lambda one: order.index(one.suite) if one.suite in order else len(order)
    )
    sections = [
        "\n\n".join(filter(None, (f"## {one.suite}", one.about, to_markdown(one))))
        for one in ordered
    ]
    return "\n".join([_ABOVE, *sections])


def with_headline(text: str, published: Sequence[Published]) -> str:
    """Put the few rows between their markers; the text around them stays."""
    table = to_headline(rows(published))
    found, count = _BLOCK.subn(lambda match: f"{match[1]}{table}{match[2]}", text)
    if count != 1:
        raise MeasureError("the README has not one place for its figures")
    return found
