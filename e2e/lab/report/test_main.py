"""``python -m e2e.lab.report``: from a file to a page, or one sentence about why not."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import pytest

from e2e.lab.report import write
from e2e.lab.report.__main__ import main
from e2e.lab.report.reader import Page, a_cell
from e2e.lab.report.synthetic import measured, run
from e2e.lab.summed import anew

if TYPE_CHECKING:
    from pathlib import Path


def test_the_command_writes_the_page_beside_the_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """``python -m e2e.lab.report RUN.json`` writes RUN.html and says so."""
    path = tmp_path / "run.json"
    path.write_text(run([measured(a_cell())]).model_dump_json(), encoding="utf-8")
    assert main([str(path)]) == 0
    assert capsys.readouterr().out.strip() == str(tmp_path / "run.html")
    write(anew(run([measured(a_cell())])), tmp_path / "other.html")
    assert (tmp_path / "run.html").read_bytes() == (tmp_path / "other.html").read_bytes()


def test_the_command_computes_the_figures_anew(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What stands in the page is what the readings say, and the run's file stays as it is."""
    was = measured(a_cell())
    assert was.figures is not None
    was.figures.pictures_per_s = 123.0
    path = tmp_path / "run.json"
    path.write_text(run([was]).model_dump_json(), encoding="utf-8")
    before = path.read_bytes()
    assert main([str(path)]) == 0
    behind = Page((tmp_path / "run.html").read_text(encoding="utf-8")).behind("30")
    assert "E2/lan/stock/0: 30 per s" in behind
    assert path.read_bytes() == before


def test_readings_of_no_instrument_are_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Columns that do not belong together: one line with the cell's name and exit 2."""
    was = measured(a_cell())
    assert was.readings is not None
    was.readings.sound.tone.pop()
    path = tmp_path / "run.json"
    path.write_text(run([was]).model_dump_json(), encoding="utf-8")
    assert main([str(path)]) == 2
    error = capsys.readouterr().err
    assert "the columns of E2/lan/stock/0 differ in length" in error
    assert len(error.splitlines()) == 1


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (None, "cannot be read"),
        (b"\xff\xfe", "is not JSON"),
        (b"{", "is not JSON"),
        (b"[1]", "is not a run of this lab"),
        (json.dumps({"started_utc": "x"}).encode(), "is not a run of this lab (took_s: "),
    ],
)
def test_what_is_no_run_is_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], content: bytes | None, said: str
) -> None:
    """A file that is missing, no JSON, or something else: one line, exit 2, nothing written."""
    path = tmp_path / "run.json"
    if content is not None:
        path.write_bytes(content)
    assert main([str(path), str(tmp_path / "out.html")]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert len(error.splitlines()) == 1
    assert not (tmp_path / "out.html").exists()


def test_a_run_is_not_overwritten_by_its_page(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A run whose name ends in .html keeps its content."""
    path = tmp_path / "run.html"
    path.write_text(run([]).model_dump_json(), encoding="utf-8")
    assert main([str(path)]) == 2
    assert "is the run itself" in capsys.readouterr().err
    assert json.loads(path.read_bytes())["cells"] == []


def test_a_page_that_cannot_be_written_is_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A folder that is not there: one line and exit 2."""
    path = tmp_path / "run.json"
    path.write_text(run([]).model_dump_json(), encoding="utf-8")
    assert main([str(path), str(tmp_path / "none" / "out.html")]) == 2
    assert "cannot be written" in capsys.readouterr().err
