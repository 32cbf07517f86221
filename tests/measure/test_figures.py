"""What is published, and the tables that are made of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from e2e.measure.errors import MeasureError
from e2e.measure.headline import HEADLINE, ROWS, headline
from e2e.measure.published import FOLDER, Published, load
from e2e.measure.readme import blocks, rendered
from e2e.measure.row import counted, judged, summed
from e2e.measure.suite import ROOT, digest
from e2e.measure.summary import summarize
from e2e.measure.table import to_markdown

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.measure.row import Row

FIGURES = (FOLDER / "README.md").read_text(encoding="utf-8")
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_quantiles_are_of_the_values_that_were_measured() -> None:
    """Of 1…200 the median is 100.5, and p99 is the 198th, not something between."""
    found = summarize([float(value) for value in range(200, 0, -1)])
    assert (found.n, found.min, found.max) == (200, 1, 200)
    assert (found.median, found.p95, found.p99) == (100.5, 190, 198)


def test_nothing_measured_is_said_and_not_summed_up() -> None:
    """An empty measurement is an error, never a row of zeros."""
    with pytest.raises(MeasureError):
        summed("x", "y", "ms", [], 1.0)


@pytest.mark.parametrize(
    ("values", "wrong", "met"),
    [([1, 2], 0, True), ([1, 3], 0, False), ([1, None], 0, False), ([1, 2], 1, False)],
    ids=["all within", "one beyond", "one never came", "one was wrong"],
)
def test_a_goal_is_met_by_every_repetition_or_missed(
    values: list[float | None], wrong: int, *, met: bool
) -> None:
    """One repetition beyond the goal, without an end, or with what must never happen misses it."""
    assert summed("x", "y", "ms", values, 2.0, wrong=wrong).met is met


def test_what_was_not_measured_is_neither_met_nor_missed() -> None:
    """Without a value there is no verdict; nothing counted of nothing is no success."""
    assert judged("x", "y", "ms", {"WAX": None}, 5.0, n=1).met is None
    assert judged("x", "y", "", {"WAX": 24.0}, 25.0, n=1, at_least=True).met is False
    assert not counted("x", "y", 0, of=0).met


def test_rows_are_stale_once_what_they_measure_has_changed(tmp_path: Path) -> None:
    """The hash follows names and code of the files that the globs match, and no other.

    Words do not count, nor do tests beside what they test.
    """
    (tmp_path / "page").mkdir()
    (tmp_path / "page/a.py").write_text("1")
    before = digest(["page/**/*.py"], tmp_path)
    (tmp_path / "page/a.txt").write_text("1")
    (tmp_path / "page/generated").mkdir()
    (tmp_path / "page/generated/b.py").write_text("1")
    (tmp_path / "page/a.test.py").write_text("1")
    (tmp_path / "page/a.py").write_text('"""What it is for."""\n\n1  # why\n"""A note,\nlong."""\n')
    assert digest(["page/**/*.py"], tmp_path) == before
    (tmp_path / "page/a.py").write_text("'#2'[1]")
    changed = digest(["page/**/*.py"], tmp_path)
    (tmp_path / "page/a.py").rename(tmp_path / "page/b.py")
    assert len({before, changed, digest(["page/**/*.py"], tmp_path)}) == 3


def test_a_table_says_missed_and_whether_the_product_has_changed() -> None:
    """A missed goal is called missed, an unmeasured one not measured; the origin stands once."""
    rows = [
        judged("a", "slow", "ms", {"WAX": 30.0, "stock": 40.0}, 20.0, n=3),
        judged("b", "unknown", "ms", {}, 20.0, n=0),
        judged("c", "only told", "", {"WAX": 0.125}, n=1, column=""),
        judged("d", "|error| is", "ms", {"off": 0.2}, 5.0, n=1, column="off"),
    ]
    published = _published(rows)
    lines = to_markdown(published, is_stale=True).splitlines()
    assert lines[2:6] == [
        "| slow | 3 | **30 ms** | 40 ms | ≤ 20 ms | **missed** |",
        "| unknown | 0 | – | – | ≤ 20 ms | not measured |",
        "| only told | 1 | 0.125 | – |  |  |",
        "| \\|error\\| is: 0.2 ms | 1 | – | – | ≤ 5 ms | met |",
    ]
    changed = "The product has changed since."
    assert lines[-1].endswith(changed)
    assert changed not in to_markdown(published, is_stale=False)
    assert published.is_stale


def test_what_was_served_meanwhile_is_said_of_its_rows_only() -> None:
    """In how many of them, unless it was the same in all."""
    alone, crowd, bigger = (
        judged("a", "slow", "ms", {"WAX": 1.0}, n=3, load=load) for load in ("", "five", "nine")
    )
    assert "Served" not in to_markdown(_published([alone]), is_stale=False)
    assert "Served meanwhile: five." in to_markdown(_published([crowd, crowd]), is_stale=False)
    mixed = to_markdown(_published([alone, crowd, crowd, bigger]), is_stale=False).split()
    assert "Served meanwhile, of 4 rows in 2: five; in 1: nine." in " ".join(mixed)


def _published(rows: list[Row]) -> Published:
    return Published(
        suite="x",
        commit="abc",
        date="2026-11-22",
        machine="a machine",
        load=0.5,
        measures=[],
        measured="0",
        columns=["WAX", "stock"],
        rows=rows,
    )


def test_only_what_is_between_markers_is_rendered() -> None:
    """The prose around a table stays as it was written; a marker alone is told."""
    text = "a\n<!-- figures: x -->\nold\n<!-- /figures -->\nb\n"
    new = rendered(text, lambda suite: f"table of {suite}\n")
    assert new == "a\n<!-- figures: x -->\ntable of x\n<!-- /figures -->\nb\n"
    with pytest.raises(MeasureError):
        rendered(text + "<!-- figures: y -->\n", lambda _: "")


PUBLISHED = sorted(FOLDER.glob("*.json"))


@pytest.mark.parametrize("path", PUBLISHED, ids=lambda path: path.stem)
def test_each_published_suite_is_rendered(path: Path) -> None:
    """Its table is made of its file; whether the product has changed since, `make` decides."""
    published = load(path.stem)
    both = [to_markdown(published, is_stale=is_stale) for is_stale in (True, False)]
    assert blocks(FIGURES).get(path.stem) in both, "run make figures"


def test_every_table_is_published() -> None:
    """Each table has a file of figures, and each file a table."""
    assert {path.stem for path in PUBLISHED} == set(blocks(FIGURES))


def test_the_readme_has_one_table_of_at_most_twelve_rows() -> None:
    """It is made of what is published, and short."""
    both = [headline(is_stale=is_stale) for is_stale in (True, False)]
    assert blocks(README).keys() == {HEADLINE}
    assert blocks(README)[HEADLINE] in both, "run make figures"
    assert len(ROWS) <= 12
