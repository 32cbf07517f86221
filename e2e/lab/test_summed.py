"""Figures can be had from the readings again, whichever version of the sums they were made by."""

from __future__ import annotations

import math

import pytest

from e2e.lab.cell import Cell
from e2e.lab.figures import Pauses
from e2e.lab.instrument.sums import figures
from e2e.lab.instrument.synthetic import OPENED_MS, readings
from e2e.lab.report.synthetic import run
from e2e.lab.results import CellResult
from e2e.lab.summed import ColumnsError, anew, summed

CARD = Cell(experiment="E2", profile="lan", system="stock")
FACE = Cell(experiment="E2", profile="lan", system="stock", content="face")


def _result(cell: Cell = CARD, *, settle_s: float = 5.0) -> CellResult:
    page = readings(20)
    if cell.content == "face":
        count = len(page.pictures.at_ms)
        page.pictures.stamp_ms = [None] * count
        # What moves the mouth is heard 100 ms later; a pattern without a period.
        page.pictures.mouth = [_opening(at_ms) for at_ms in page.pictures.at_ms]
        page.sound.rms = [0.2 * _opening(at_ms - 100) for at_ms in page.sound.start_ms]
    return CellResult(
        cell=cell,
        status="ok",
        started_utc="",
        took_s=20.0,
        figures=summed(cell, page, settle_s=settle_s),
        readings=page,
    )


def _opening(at_ms: float) -> float:
    at_s = (at_ms - OPENED_MS) / 1000
    return 0.5 + 0.25 * math.sin(5 * at_s + 3 * math.sin(1.3 * at_s)) + 0.2 * math.sin(11.7 * at_s)


def test_a_sum_that_was_mended_is_mended_in_old_runs() -> None:
    """What an old version summed up wrongly is right again, over the same time."""
    was = _result()
    assert was.figures is not None
    right = was.figures.model_copy(deep=True)
    was.figures.tone_pauses = Pauses(at_ms=[OPENED_MS], length_ms=[900])
    was.figures.sound_from_ms = None
    was.figures.pictures_per_s = 3.0
    (again,) = anew(run([was])).cells
    assert again.figures is not None
    assert again.figures.from_ms == pytest.approx(OPENED_MS + 5000, abs=0.01)
    exact = {"from_ms", "sound_from_ms"}
    assert again.figures.model_dump(exclude=exact) == right.model_dump(exclude=exact)
    assert was.figures.pictures_per_s == 3.0


def test_the_lips_are_judged_again_where_the_face_was_shown() -> None:
    """A face's lag is found from the readings; the test card has none."""
    was = _result(FACE)
    assert was.figures is not None
    assert was.figures.lip_lag_ms == pytest.approx(100, abs=15)
    bare = was.model_copy(update={"figures": figures(readings(20), settle_s=5.0)})
    (again,) = anew(run([bare])).cells
    assert again.figures is not None
    assert again.figures.lip_lag_ms == pytest.approx(was.figures.lip_lag_ms, abs=0.1)
    (card,) = anew(run([_result()])).cells
    assert card.figures is not None
    assert card.figures.lip_lag_ms is None


def test_what_has_no_readings_stays_as_it_is() -> None:
    """A cell that was not run has nothing to compute anew."""
    lone = CellResult(cell=CARD, status="not run", problem="no", started_utc="", took_s=0.0)
    assert anew(run([lone])).cells == [lone]


def test_columns_of_different_lengths_are_told() -> None:
    """Readings that belong to no instrument are named, not summed up."""
    was = _result()
    assert was.readings is not None
    was.readings.sound.tone.pop()
    with pytest.raises(ColumnsError, match="E2/lan/stock/0"):
        anew(run([was]))
