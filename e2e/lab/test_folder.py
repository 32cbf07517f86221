"""What a run has written is there after a crash, and whoever continues it finds it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from e2e.lab.cell import Cell
from e2e.lab.errors import LabError
from e2e.lab.folder import CELLS, PLAN, RUNS, Begun, RunFolder
from e2e.lab.results import CellResult, Run

if TYPE_CHECKING:
    from pathlib import Path

ONE = Cell(experiment="E1", profile="lan", system="thesis", audio_mu_ms=100)
OTHER = Cell(experiment="E1", profile="lan", system="thesis", audio_mu_ms=200)


def begun() -> Begun:
    return Begun(
        started_utc="2024-01-01T00:00:00+00:00",
        arguments=[],
        machine={"cores": 2},
        cells=[ONE, OTHER],
        own_error=False,
        strict=True,
    )


def ok(cell: Cell) -> CellResult:
    return CellResult(cell=cell, status="ok", started_utc="2024-01-01T00:00:00+00:00", took_s=1.0)


def bad(cell: Cell) -> CellResult:
    return ok(cell).model_copy(update={"status": "failed", "problem": "the link broke"})


def run_of(folder: RunFolder) -> Run:
    wanted = folder.begun
    return Run(
        started_utc=wanted.started_utc,
        took_s=1.0,
        arguments=[],
        machine=wanted.machine,
        cells=folder.results(),
    )


def test_a_finished_cell_is_on_the_disk(tmp_path: Path) -> None:
    """A cell that was added is found by whoever opens the folder next, with the plan."""
    RunFolder.create(tmp_path / "run", begun()).add(ok(ONE))
    found = RunFolder.unfinished(tmp_path / "run")
    assert found.results() == [ok(ONE)]
    assert found.begun == begun()


def test_a_torn_line_costs_its_cell_only(tmp_path: Path) -> None:
    """Half a line at the end, which a crash left, is taken away; what follows is whole again."""
    folder = RunFolder.create(tmp_path, begun())
    folder.add(ok(ONE))
    with (tmp_path / CELLS).open("a") as file:
        file.write(ok(OTHER).model_dump_json()[:50])
    again = RunFolder.unfinished(tmp_path)
    assert again.results() == [ok(ONE)]
    again.add(ok(OTHER))
    assert again.results() == [ok(ONE), ok(OTHER)]


def test_what_failed_is_left_until_it_goes_well(tmp_path: Path) -> None:
    """An ended run with a failed cell can be continued; of one measured twice the last counts."""
    folder = RunFolder.create(tmp_path, begun())
    folder.add(bad(ONE))
    folder.add(ok(OTHER))
    folder.finish(run_of(folder))
    again = RunFolder.unfinished(tmp_path)
    assert again.begun.left(again.results()) == [ONE]
    again.add(ok(ONE))
    assert again.results() == [ok(ONE), ok(OTHER)]
    with pytest.raises(LabError, match=r"no cell of it failed.*e2e\.lab\.report"):
        RunFolder.unfinished(tmp_path)


def test_the_newest_unfinished_run_is_continued(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without a name, the last run that has no end is the one to continue."""
    monkeypatch.chdir(tmp_path)
    for name in ("2024-01-01-000000", "2024-01-02-000000", "2024-01-03-000000"):
        last = RunFolder.create(RUNS / name, begun())
    last.finish(run_of(last))
    assert RunFolder.unfinished(None).path.name == "2024-01-02-000000"


def test_nothing_to_resume_is_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No run, a folder without one, a finished one and a strange plan are told apart."""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(LabError, match="there is no unfinished run"):
        RunFolder.unfinished(None)
    with pytest.raises(LabError, match="holds no run"):
        RunFolder.unfinished(tmp_path)
    folder = RunFolder.create(tmp_path / "done", begun())
    for cell in (ONE, OTHER):
        folder.add(ok(cell))
    folder.finish(run_of(folder))
    with pytest.raises(LabError, match="is finished"):
        RunFolder.unfinished(tmp_path / "done")
    (tmp_path / PLAN).write_text('{"cells": 3}')
    with pytest.raises(LabError, match="another version"):
        RunFolder.unfinished(tmp_path)


def test_an_unwritable_folder_is_one_sentence(tmp_path: Path) -> None:
    """Where no folder can be made the sentence says which, and what to do."""
    (tmp_path / "file").touch()
    with pytest.raises(LabError, match=r"cannot write to .*file/run .*--out"):
        RunFolder.create(tmp_path / "file" / "run", begun())


def test_a_run_is_not_written_over(tmp_path: Path) -> None:
    """A folder that holds a run already is refused."""
    RunFolder.create(tmp_path, begun())
    with pytest.raises(LabError, match="--resume"):
        RunFolder.create(tmp_path, begun())


def test_the_files_of_a_cell_come_and_go(tmp_path: Path) -> None:
    """What a system wrote is there until it is dropped, and then no empty folder is."""
    folder = RunFolder.create(tmp_path, begun())
    (folder.files_of(ONE) / "log").write_text("said")
    folder.files_of(OTHER)
    folder.drop_files_of(OTHER)
    assert (folder.files_of(ONE) / "log").read_text() == "said"
    folder.drop_files_of(ONE)
    assert [path.name for path in tmp_path.iterdir()] == [PLAN]
