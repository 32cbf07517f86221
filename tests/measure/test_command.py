"""A suite's command: what it measures, keeps, and leaves to be measured."""

from __future__ import annotations

from argparse import Namespace
from typing import TYPE_CHECKING

import pytest
from e2e.measure import command, machine, runner
from e2e.measure.errors import MeasureError, NotRunError
from e2e.measure.row import Row, judged
from e2e.measure.suite import Case, Suite

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path


def _only_one(rows: list[Row]) -> list[Row]:
    return [row for row in rows if row.key == "one"]


class Bed:
    """A suite of two cases and a long one; it counts measurements and fails on request."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.runs: list[tuple[str, int]] = []
        self.wrong: dict[str, Exception] = {}
        self.value = 1.0

        cases = tuple(
            Case(key, "runs", 10, self._case(key), long=key == "hours")
            for key in ("one", "two", "hours")
        )
        self.suite = Suite("bed", "A test bed.", ("README.md",), ("WAX",), cases, derive=_only_one)

    def run(self, *words: str) -> int:
        return command.main(self.suite, [*words, "--out", str(self.folder)])

    def left(self) -> list[str]:
        """Return what the runner would still measure."""
        chosen = {"only": None, "n": None, "quick": False, "long": False, "again": False}
        arguments = Namespace(**chosen, out=self.folder)
        return [task.case.key for task in runner.planned({"bed": self.suite}, arguments)]

    def _case(self, key: str) -> Callable[[int], list[Row]]:
        def measure(n: int) -> list[Row]:
            self.runs.append((key, n))
            if key in self.wrong:
                raise self.wrong[key]
            return [judged(key, key, "ms", {"WAX": self.value}, 2.0, n=n, detail={"raw": 1})]

        return measure


@pytest.fixture(scope="module")
def here() -> machine.Machine:
    return machine.describe()


@pytest.fixture
def bed(here: machine.Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Bed:
    monkeypatch.setattr(machine, "describe", lambda: here)
    monkeypatch.setattr(machine, "commit", lambda: "abc")
    return Bed(tmp_path)


def test_a_run_that_failed_goes_on_with_what_is_left(bed: Bed) -> None:
    """A failed case costs no other, and it alone is left."""
    bed.wrong = {"one": OSError("no board")}
    assert bed.run() == 2
    assert bed.runs == [("one", 10), ("two", 10)]
    assert bed.left() == ["one"]


def test_a_torn_line_costs_its_own_case(bed: Bed) -> None:
    """A half-written result is measured again, and the results after it are kept."""
    bed.run("--only", "one")
    results = bed.folder / "bed/results.jsonl"
    results.write_text(results.read_text()[:-20])
    bed.run("--only", "two")
    assert bed.left() == ["one"]


def test_results_of_another_product_or_number_do_not_count(
    bed: Bed, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Only results of the same product count, repeated as often as requested."""
    bed.run("--quick")
    assert bed.left() == ["one", "two"]
    bed.run()
    assert bed.left() == []
    monkeypatch.setattr(command, "digest", lambda _: "other")
    assert bed.left() == ["one", "two"]


def test_results_of_another_commit_do_not_count(bed: Bed, monkeypatch: pytest.MonkeyPatch) -> None:
    """All figures of a suite are of one commit."""
    bed.run()
    monkeypatch.setattr(machine, "commit", lambda: "def")
    assert bed.left() == ["one", "two"]


def test_what_no_commit_has_counts_for_no_other(bed: Bed, monkeypatch: pytest.MonkeyPatch) -> None:
    """A run with uncommitted changes leaves nothing to publish."""
    monkeypatch.setattr(machine, "commit", lambda: "abc-dirty")
    bed.run()
    assert bed.left() == ["one", "two"]
    monkeypatch.setattr(machine, "commit", lambda: "abc")
    assert bed.left() == ["one", "two"]


@pytest.mark.parametrize(
    ("wrong", "value", "status"),
    [(None, 1.0, 0), (None, 3.0, 1), (MeasureError("no"), 1.0, 2), (NotRunError("no"), 1.0, 77)],
    ids=["met", "missed", "failed", "not run"],
)
def test_the_exit_status_says_what_came_of_it(
    bed: Bed, wrong: Exception | None, value: float, status: int
) -> None:
    """It is 0 only if everything was measured and every goal is met."""
    bed.value = value
    bed.wrong = {} if wrong is None else {"two": wrong}
    assert bed.run() == status


def test_a_case_that_is_not_there_is_told(bed: Bed, capsys: pytest.CaptureFixture[str]) -> None:
    """A name that matches nothing measures nothing, and the sentence has the nearest name."""
    assert bed.run("--only", "tow") == 2
    assert "did you mean two?" in capsys.readouterr().err
    assert bed.runs == []


def test_what_takes_hours_is_asked_for(bed: Bed, capsys: pytest.CaptureFixture[str]) -> None:
    """A long case runs with --long only; named without it, the command says so."""
    assert bed.run() == 0
    assert bed.run("--only", "hours") == 2
    assert "hours takes hours; add --long" in capsys.readouterr().err
    bed.run("--long", "--only", "hours")
    assert [key for key, _ in bed.runs] == ["one", "two", "hours"]


def test_what_changes_meanwhile_is_not_kept(bed: Bed, monkeypatch: pytest.MonkeyPatch) -> None:
    """A case during which the tree changed has no result."""
    commits = iter(["abc", "def"])
    monkeypatch.setattr(machine, "commit", lambda: next(commits, "abc"))
    assert bed.run("--only", "one") == 2
    assert bed.left() == ["one", "two"]
