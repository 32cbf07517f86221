"""A cell's row of figures, as a test imagines it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from e2e.measure.row import Row

if TYPE_CHECKING:
    from e2e.delay.cell import Cell


def measured(of: Cell, **values: float | None) -> Row:
    return Row(key=of.key, what="", n=1, values=values, detail={"cell": of.model_dump()})
