"""The published figures, and the tables made from them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from e2e.measure.errors import MeasureError
from e2e.measure.headline import ROWS, rows
from e2e.measure.published import FOLDER, everything
from e2e.measure.render import page, with_headline
from e2e.measure.row import counted, judged, summarize, summed
from e2e.measure.runner import SUITES
from e2e.measure.suite import ROOT, digest
from e2e.measure.table import to_headline, to_markdown
from tests.measure.imagined_figures import imagined

if TYPE_CHECKING:
    from pathlib import Path


PUBLISHED = everything()
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
    """One repetition beyond the goal, without an end, or with a forbidden event misses it."""
    assert summed("x", "y", "ms", values, 2.0, wrong=wrong).met is met


def test_what_was_not_measured_is_neither_met_nor_missed() -> None:
    """Without a value there is no verdict; a count of 0 among 0 is no success."""
    assert judged("x", "y", "ms", {"WAX": None}, 5.0, n=1).met is None
    assert judged("x", "y", "", {"WAX": 24.0}, 25.0, n=1, at_least=True).met is False
    assert not counted("x", "y", 0, of=0).met


def test_a_change_of_what_is_measured_is_found(tmp_path: Path) -> None:
    """The hash follows names and code of the files that the globs match, and of no others.

    Comments do not count, nor do tests next to the code.
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


def test_a_table_says_missed_and_where_it_was_measured() -> None:
    """A missed goal is called missed, an unmeasured one not measured; the origin is there once."""
    lines = to_markdown(
        imagined(
            rows=[
                judged("a", "slow", "ms", {"WAX": 30.0, "stock": 40.0}, 20.0, n=3),
                judged("b", "unknown", "ms", {}, 20.0, n=0),
                judged("c", "only told", "", {"WAX": 0.125}, n=1, column=""),
                judged("d", "|error| is", "ms", {"off": 0.2}, 5.0, n=1, column="off"),
            ]
        )
    ).splitlines()
    assert lines[2:6] == [
        "| slow | 3 | **30 ms** | 40 ms | ≤ 20 ms | **missed** |",
        "| unknown | 0 | – | – | ≤ 20 ms | not measured |",
        "| only told | 1 | 0.125 | – |  |  |",
        "| \\|error\\| is: 0.2 ms | 1 | – | – | ≤ 5 ms | met |",
    ]
    assert lines[7:] == ["Version 1.2.3, commit abc, 2026-11-22, a machine, load 0.5 before."]


def test_what_was_served_meanwhile_is_said_of_its_rows_only() -> None:
    """The load is given with the number of its rows, unless it was the same in all."""
    alone, crowd, bigger = (
        judged("a", "slow", "ms", {"WAX": 1.0}, n=3, load=load) for load in ("", "five", "nine")
    )
    assert "served" not in to_markdown(imagined(rows=[alone]))
    assert "The server meanwhile served five." in to_markdown(imagined(rows=[crowd, crowd]))
    mixed = " ".join(to_markdown(imagined(rows=[alone, crowd, crowd, bigger])).split())
    said = "The server meanwhile served five (2 of the 4 rows) or nine (1 of the 4 rows)."
    assert said in mixed


def test_the_readme_shows_the_newest_of_each_row() -> None:
    """Only the text between the markers is replaced; a single marker or a missing row is an error.

    If two suites have published one key, the later figure counts.
    """
    found = [imagined(rows=[judged(key, key, "ms", {"WAX": 1.0}, n=1) for key in ROWS])]
    key, what = next(iter(ROWS.items()))
    found.append(imagined(rows=[judged(key, "newer", "ms", {"WAX": 2.0}, n=1)], date="2026-12-01"))
    text = "a\n<!-- figures: headline -->\nold\n<!-- /figures -->\nb\n"
    lines = with_headline(text, found).splitlines()
    assert (lines[0], lines[-1], "old" in lines) == ("a", "b", False)
    assert lines[4] == f"| {what} | 1 | **2 ms** | – | – | – |  |"
    for broken in (text * 2, "a\n"):
        with pytest.raises(MeasureError):
            with_headline(broken, found)
    with pytest.raises(MeasureError, match="nothing publishes"):
        rows(found[1:])


@pytest.mark.parametrize(
    ("values", "at_least", "said"),
    [
        ({"WAX": 30.0, "stock aiortc": 120.0, "LiveKit": 40.0}, False, "25 % better"),
        ({"WAX": 42.0, "stock aiortc": 120.0, "LiveKit": 40.0}, False, "5 % worse"),
        ({"WAX": 0.72, "stock aiortc": 0.75, "LiveKit": None}, True, "4 % worse"),
        ({"WAX": 1.0, "stock aiortc": 0.0, "LiveKit": 2.0}, False, ""),
        ({"max": 30.0}, False, ""),
    ],
    ids=["sooner", "later", "less sharp", "nothing is better", "no peer"],
)
def test_the_readme_says_how_much_better_or_worse(
    values: dict[str, float | None], said: str, *, at_least: bool
) -> None:
    """WAX stands beside the best of the peers; where there is none, nothing is claimed."""
    ours = next(iter(values))
    row = judged("a", "b", "ms", values, 20.0, n=3, column=ours, at_least=at_least)
    line = to_headline([(imagined(rows=[row]), row)]).splitlines()[2]
    assert line.endswith(f"| {said} |")


def test_what_is_published_is_rendered() -> None:
    """Every table, and the few rows of the README, match the files."""
    assert (FOLDER / "README.md").read_text(encoding="utf-8") == page(PUBLISHED)
    assert with_headline(README, PUBLISHED) == README, "type make measure ARGS=--render"


def test_what_is_published_stays_readable() -> None:
    """The README has at most 12 rows, the suites together at most 140."""
    assert len(ROWS) <= 12
    assert sum(len(one.rows) for one in PUBLISHED if one.suite in SUITES) <= 140
