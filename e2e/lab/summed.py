"""From one cell's readings to its figures, as often as wanted: the readings are kept."""

from __future__ import annotations

from typing import TYPE_CHECKING

from e2e.lab.face.lips import lip_lag
from e2e.lab.instrument.sums import begin_ms, figures

if TYPE_CHECKING:
    from e2e.lab.cell import Cell
    from e2e.lab.figures import Figures
    from e2e.lab.readings import Readings
    from e2e.lab.results import CellResult, Run


class ColumnsError(ValueError):
    """Readings that no instrument has made."""


def summed(
    cell: Cell, readings: Readings, *, settle_s: float, to_ms: float | None = None
) -> Figures:
    """Sum up as `figures` does, and judge the lips where the face was shown."""
    found = figures(readings, settle_s=settle_s, to_ms=to_ms)
    if cell.content != "face":
        return found
    lag = lip_lag(readings, from_ms=found.from_ms, to_ms=found.to_ms)
    if lag is None:
        return found
    return found.model_copy(update={"lip_lag_ms": lag.lag_ms, "lip_correlation": lag.correlation})


def anew(run: Run) -> Run:
    """Compute the figures of every cell again, over the time that they are of.

    So a run that was measured before a sum was mended has the mended one. Raises `ColumnsError`
    with the cell's name where columns that belong together differ in length.
    """
    return run.model_copy(update={"cells": [_anew(result) for result in run.cells]})


def _anew(result: CellResult) -> CellResult:
    readings, old = result.readings, result.figures
    if readings is None or old is None:
        return result
    settle_s = (old.from_ms - begin_ms(readings)) / 1000
    try:
        again = summed(result.cell, readings, settle_s=settle_s, to_ms=old.to_ms)
    except (ValueError, IndexError) as error:
        raise ColumnsError(f"the columns of {result.cell.key} differ in length") from error
    return result.model_copy(update={"figures": again})
