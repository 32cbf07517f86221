"""Cells as cases: what fails costs no other, what hangs is cut off, what is missing is said."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any

import pytest
from tests.link.errors import LinkError

from e2e.delay import apparatus as cases
from e2e.delay.apparatus import Apparatus
from e2e.delay.cell import Cell
from e2e.delay.test_measures import result
from e2e.instrument.synthetic import readings
from e2e.link import UnavailableError
from e2e.measure.errors import MeasureError, NotRunError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from e2e.delay.results import CellResult

CELL = Cell(experiment="E2", profile="lan", system="stock", seconds=0.0)
OTHER = CELL.model_copy(update={"system": "livekit"})


class FakeStage:
    """Says what it was asked for; `gone` is set once it was cleared."""

    link = browser = None

    def __init__(self) -> None:
        self.said: list[str] = []
        self.gone = asyncio.Event()

    async def set_for(self, cell: Cell) -> None:
        self.said.append(cell.system)

    async def clear(self) -> None:
        self.said.append("cleared")
        self.gone.set()


@pytest.fixture
def stage(monkeypatch: pytest.MonkeyPatch) -> FakeStage:
    made = FakeStage()
    monkeypatch.setattr(cases, "Stage", lambda: made)
    return made


def watching(
    monkeypatch: pytest.MonkeyPatch, found: Callable[[Cell], CellResult | Exception]
) -> list[Cell]:
    """Have cells give what `found` says, and list them as they are watched."""
    asked: list[Cell] = []

    async def watch(cell: Cell, *_: object) -> CellResult:
        asked.append(cell)
        given = found(cell)
        if isinstance(given, Exception):
            raise given
        return given

    monkeypatch.setattr(cases, "watch", watch)
    return asked


def test_a_cell_leaves_a_row_and_all_that_was_read(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, stage: FakeStage
) -> None:
    """Its figures are in the row by name; the readings they are made of lie in its folder."""
    watching(monkeypatch, lambda cell: result(readings(10), cell))
    with Apparatus(tmp_path, strict=True) as apparatus:
        (row,) = apparatus.case(CELL).run(1)
    assert row.values["picture_age_p50_ms"] == pytest.approx(80, abs=1)
    assert Cell.model_validate(row.detail["cell"]) == CELL
    assert (tmp_path / "cells" / "E2-lan-stock-0s-0" / "read.json").exists()
    assert stage.said == ["stock", "cleared"]


@pytest.mark.parametrize("strict", [True, False])
def test_a_cell_without_a_picture_fails_where_that_is_asked(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, stage: FakeStage, *, strict: bool
) -> None:
    """Else it is what was found, with its sentence; either way the next one starts afresh."""
    blind = "there was no picture within 30 s"
    watching(monkeypatch, lambda cell: result(readings(10), cell, problem=blind))
    with Apparatus(tmp_path, strict=strict) as apparatus:
        if strict:
            with pytest.raises(MeasureError, match=blind):
                apparatus.case(CELL).run(1)
        else:
            (row,) = apparatus.case(CELL).run(1)
            assert row.detail["problem"] == blind
        assert stage.said[:2] == ["stock", "cleared"]


@pytest.mark.parametrize(
    ("raised", "kind"),
    [
        (LinkError("the forwarder has ended"), MeasureError),
        (UnavailableError("no TUN here"), NotRunError),
        (RuntimeError("whatever"), RuntimeError),
    ],
)
def test_what_a_link_says_is_what_the_measurement_says(
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    stage: FakeStage,
    raised: Exception,
    kind: type[Exception],
) -> None:
    """A broken link has failed, one that cannot be had was not run; all else comes as it is."""
    watching(monkeypatch, lambda _: raised)
    with (
        Apparatus(tmp_path, strict=True) as apparatus,
        pytest.raises(kind, match=str(raised)) as found,
    ):
        apparatus.case(CELL).run(1)
    assert found.type is kind


def test_what_is_missing_is_looked_for_once(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, stage: FakeStage
) -> None:
    """A system that cannot be had is asked for once, and every cell of it says why."""
    asked = watching(
        monkeypatch,
        lambda cell: NotRunError("there is no Go") if cell == OTHER else result(readings(9), cell),
    )
    with Apparatus(tmp_path, strict=True) as apparatus:
        for _ in range(2):
            with pytest.raises(NotRunError, match="there is no Go"):
                apparatus.case(OTHER).run(1)
        apparatus.case(CELL).run(1)
    assert asked == [OTHER, CELL]


@pytest.mark.parametrize("stubborn", [False, True])
def test_a_hung_cell_is_cut_off(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, stage: FakeStage, *, stubborn: bool
) -> None:
    """A cell that does not end is ended, with its link where it holds on to that."""
    monkeypatch.setattr(cases, "_LEAVE_WITHIN_S", 0.05)

    async def watch(*_: Any) -> CellResult:
        try:
            await asyncio.Event().wait()
        finally:
            if stubborn:
                await stage.gone.wait()
        raise AssertionError

    monkeypatch.setattr(cases, "watch", watch)
    with (
        Apparatus(tmp_path, strict=True, beyond_s=0.05) as apparatus,
        pytest.raises(MeasureError, match="it hung and was cut off"),
    ):
        apparatus.case(CELL).run(1)
    assert "cleared" in stage.said
