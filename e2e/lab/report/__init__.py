"""The report: from one run of the lab to one page that a person wants to read."""

from __future__ import annotations

from typing import TYPE_CHECKING

from e2e.lab.report.page import html

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.lab.results import Run

__all__ = ["write"]


def write(run: Run, path: Path) -> None:
    """Write the page: one file with its plots in it, no script; raises `OSError`."""
    path.write_text(html(run), encoding="utf-8")
