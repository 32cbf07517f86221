"""Two runs side by side: what counts as moved, and what is only said."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import pytest

from e2e.lab.cell import Cell
from e2e.lab.compare import compare, main, to_text
from e2e.lab.figures import Quantiles
from e2e.lab.report.synthetic import MACHINE, failed, measured, run

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.lab.compare import Comparison, Moved
    from e2e.lab.results import Run

CELL = Cell(experiment="E2", profile="lan", system="stock")


def _run(*p50_ms: float, cell: Cell = CELL) -> Run:
    """One repetition for each median age of the picture."""
    cells = []
    for repeat, ms in enumerate(p50_ms):
        result = measured(cell.model_copy(update={"repeat": repeat}))
        assert result.figures is not None
        result.figures.picture_age_ms = Quantiles(n=9, min=ms, p50=ms, p95=ms, max=ms)
        cells.append(result)
    return run(cells)


def _age(found: Comparison) -> Moved:
    return next(one for one in found.moved if one.figure == "picture_age_p50_ms")


def test_a_run_has_not_moved_from_itself() -> None:
    """Every figure is there, and none is beyond its limit."""
    found = compare(_run(50, 60), _run(50, 60))
    assert len(found.moved) > 20
    assert all(one.difference == 0 and one.beyond == 0 for one in found.moved)
    assert "None of " in to_text(found, "a", "b")


def test_within_the_spread_is_not_beyond() -> None:
    """The wider of the two ranges is the limit, whichever run it is of."""
    moved = _age(compare(_run(50, 60, 90), _run(75, 80, 85)))
    assert (moved.difference, moved.limit, moved.limit_is) == (20.0, 40.0, "spread")
    assert moved.beyond == pytest.approx(0.5)
    assert _age(compare(_run(75, 80, 85), _run(50, 60, 90))).beyond == pytest.approx(0.5)


def test_beyond_the_spread_counts() -> None:
    """A difference above both ranges is beyond, and stands in the table with both medians."""
    found = compare(_run(50, 55, 60), _run(100, 105, 110))
    moved = _age(found)
    assert moved.beyond == pytest.approx(5.0)
    text = to_text(found, "a", "b")
    assert "55 (50…60)" in text
    assert "105 (100…110)" in text
    assert "+50" in text


def test_without_repetitions_a_tenth_is_the_limit_and_that_is_said() -> None:
    """With one repetition in each there is no spread; the text says against what it was held."""
    found = compare(_run(100), _run(112))
    moved = _age(found)
    assert (moved.limit, moved.limit_is) == (10.0, "10 %")
    assert "no repetitions, so there is no spread" in to_text(found, "a", "b")


def test_less_than_the_instruments_error_never_counts() -> None:
    """Repetitions that agree to the millisecond do not make 4 ms a difference."""
    moved = _age(compare(_run(50, 50, 50), _run(54, 54, 54)))
    assert (moved.limit, moved.limit_is) == (5.0, "instrument")
    assert moved.beyond < 1


def test_the_farthest_beyond_comes_first() -> None:
    """The order is by how many times the limit, not by milliseconds."""
    far = CELL.model_copy(update={"profile": "satellite"})
    a = run([*_run(20).cells, *_run(1000, cell=far).cells])
    b = run([*_run(60).cells, *_run(1150, cell=far).cells])
    beyond = [one for one in compare(a, b).moved if one.beyond > 1]
    variants = [one.variant for one in beyond if one.figure == "picture_age_p50_ms"]
    assert variants == ["E2/lan/stock", "E2/satellite/stock"]


def test_variants_in_one_run_only_are_named() -> None:
    """Nothing disappears without a word."""
    other = CELL.model_copy(update={"system": "operator"})
    found = compare(_run(50), _run(50, cell=other))
    assert (found.only_a, found.only_b) == (["E2/lan/stock"], ["E2/lan/operator"])
    text = to_text(found, "a", "b")
    assert "Only in A: E2/lan/stock" in text
    assert "Only in B: E2/lan/operator" in text


def test_a_cell_that_broke_is_said_with_its_sentence() -> None:
    """Ok before and failed now is no difference of figures, but it is told."""
    found = compare(_run(50), run([failed(CELL, "No picture came.")]))
    assert found.remarks == ["E2/lan/stock: ok in A, in B failed: No picture came."]


def test_a_figure_that_vanished_is_said() -> None:
    """What one run has of a variant and the other has not is no difference, but it is told."""
    without = _run(50)
    figures = without.cells[0].figures
    assert figures is not None
    figures.sound_age_ms = None
    found = compare(_run(50), without)
    assert found.remarks == ["E2/lan/stock: only A has sound, p50; sound, p95"]
    assert found.remarks[0] in to_text(found, "a", "b")
    assert compare(without, _run(50)).remarks == ["E2/lan/stock: only B has sound, p50; sound, p95"]


def test_other_machines_and_commits_are_said() -> None:
    """Another processor makes times incomparable; another commit is named."""
    b = run([], machine={**MACHINE, "cpu": "Another", "commit": "deadbee"})
    (said,) = compare(run([]), b).remarks
    assert said.startswith("Different machines")
    assert "cpu An imagined processor → Another" in said
    assert "commit c316766 → deadbee" in said
    assert compare(run([]), run([])).remarks == []


def test_the_command_writes_a_table_or_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """For people a table, with ``--json`` everything."""
    for name, p50_ms in (("a", 50.0), ("b", 90.0)):
        (tmp_path / name).write_text(_run(p50_ms).model_dump_json(), encoding="utf-8")
    names = [str(tmp_path / "a"), str(tmp_path / "b")]
    assert main(names) == 0
    assert "picture, p50" in capsys.readouterr().out
    assert main([*names, "--json"]) == 0
    tree = json.loads(capsys.readouterr().out)
    assert tree["moved"][0]["difference"] == 40.0


def test_what_is_no_run_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A file that is not there or something else: one line and exit 2."""
    other = tmp_path / "other.json"
    other.write_text("{}", encoding="utf-8")
    assert main([str(tmp_path / "none"), str(other)]) == 2
    assert main([str(other), str(other)]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert "cannot be read" in lines[0]
    assert "is not a run of this lab" in lines[1]
    assert len(lines) == 2
