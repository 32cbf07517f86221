"""`make measure`: one commit, unattended, resumable; complete suites are published."""

from __future__ import annotations

import subprocess
import sys
import time
from typing import TYPE_CHECKING

import pytest
from e2e.measure import headline, runner
from e2e.measure.__main__ import main
from e2e.measure.published import load
from e2e.measure.suite import ROOT

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = pytest.mark.system

GIT = """#!/bin/sh
case "$*" in
*rev-parse*) cat "$BED/commit" ;;
*status*) cat "$BED/changed" ;;
esac
"""


class Bed:
    """The suite in `bed`, with a tree at a commit that the tests choose."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.say("commit", "abc")
        self.say("changed", "")
        self.say("README.md", "a\n<!-- figures: headline -->\n<!-- /figures -->\nb\n")

    def say(self, name: str, text: str) -> None:
        (self.folder / name).write_text(text, encoding="utf-8")

    def run(self, *words: str) -> int:
        return main(
            [*words, "--out", str(self.folder)],
            suites={"bed": "tests.measure.bed"},
            published=self.folder / "published",
            readme=self.folder / "README.md",
        )

    def runs(self) -> list[str]:
        """Return the cases that were measured since the last call, each with its number."""
        path = self.folder / "runs"
        found = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
        path.unlink(missing_ok=True)
        return found


@pytest.fixture
def bed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Bed:
    git = tmp_path / "bin/git"
    git.parent.mkdir()
    git.write_text(GIT, encoding="utf-8")
    git.chmod(0o755)
    monkeypatch.setenv("PATH", str(git.parent), prepend=":")
    monkeypatch.setenv("BED", str(tmp_path))
    monkeypatch.setattr(headline, "ROWS", {"one": "one"})
    return Bed(tmp_path)


def test_the_same_words_go_on_and_publish(bed: Bed, capfd: pytest.CaptureFixture[str]) -> None:
    """Only what failed is measured again; then the suite and its tables are written."""
    bed.say("one", "fails")
    assert bed.run() == 2
    assert bed.runs() == ["one 10", "two 10"]
    said = capfd.readouterr().err
    assert "bed: one, 1 of 2; 1 min left, until " in said
    assert "bed is not published, without one" in said
    bed.say("one", "")
    assert bed.run() == 0
    assert bed.runs() == ["one 10"]
    published = load(bed.folder / "published/bed.json")
    assert (published.commit, [row.key for row in published.rows]) == ("abc", ["one", "two"])
    assert "| one | 10 | **1 ms** |" in (bed.folder / "published/README.md").read_text()
    readme = (bed.folder / "README.md").read_text()
    assert "| one | 10 | **1 ms** |" in readme
    assert readme.startswith("a\n")
    bed.run()
    assert bed.runs() == []
    bed.run("--only", "two", "--again")
    assert bed.runs() == ["two 10"]


def test_another_commit_ends_the_run(bed: Bed, capfd: pytest.CaptureFixture[str]) -> None:
    """The interrupted measurement is dropped; back on the old commit the run resumes."""
    bed.say("one", "moves")
    assert bed.run() == 2
    assert bed.runs() == ["one 10"]
    assert "this began on abc, and the tree is def now" in capfd.readouterr().err
    bed.say("commit", "abc")
    bed.say("one", "")
    assert bed.run() == 0
    assert bed.runs() == ["one 10", "two 10"]


def test_what_is_not_committed_is_neither_published_nor_kept(bed: Bed) -> None:
    """A few cases may be tried, each time anew."""
    bed.say("changed", " M server/wax/app.py")
    assert bed.run() == 2
    assert bed.runs() == []
    for _ in range(2):
        assert bed.run("--only", "two", "--quick") == 0
        assert bed.runs() == ["two 1"]
    assert not (bed.folder / "published").exists()


def test_a_case_that_hangs_costs_itself(bed: Bed, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is ended, and the others are measured."""
    monkeypatch.setattr(runner, "_HANGS_MINUTES", 0.03)
    bed.say("one", "hangs")
    assert bed.run() == 2
    assert bed.runs()[-1] == "two 10"


def test_a_case_ends_with_its_runner(bed: Bed) -> None:
    """A killed run leaves no case that keeps measuring."""
    bed.say("one", "hangs")
    words = ["e2e.measure.command", "tests.measure.bed", "--only", "one", "--out", str(bed.folder)]
    with subprocess.Popen(
        [sys.executable, "-m", *words], cwd=ROOT, stdin=subprocess.PIPE
    ) as process:
        assert process.stdin is not None
        while not (bed.folder / "runs").exists():
            time.sleep(0.05)
        process.stdin.close()
        assert process.wait(30) == 130


def test_what_takes_hours_is_listed_when_asked_for(
    bed: Bed, capsys: pytest.CaptureFixture[str]
) -> None:
    """`--list` lists the cases, and measures nothing."""
    assert bed.run("--list") == 0
    assert "2 cases" in capsys.readouterr().out
    assert bed.run("--list", "--long") == 0
    assert "(long)" in capsys.readouterr().out
    assert bed.runs() == []


def test_what_no_suite_publishes_any_more_goes(bed: Bed, monkeypatch: pytest.MonkeyPatch) -> None:
    """Once every suite is published, the files and tables of former suites are removed."""
    monkeypatch.setattr(runner, "SUITES", {"bed": "tests.measure.bed"})
    bed.run()
    former = bed.folder / "published/former.json"
    (bed.folder / "published/bed.json").rename(former)
    bed.run()
    assert not former.exists()
    assert (bed.folder / "published/bed.json").exists()


def test_changed_suites_are_named(bed: Bed, capsys: pytest.CaptureFixture[str]) -> None:
    """A suite whose measured files have changed is listed with its commit."""
    bed.run()
    capsys.readouterr()
    bed.run("--changed")
    assert capsys.readouterr().out == ""
    path = bed.folder / "published/bed.json"
    published = load(path)
    path.write_text(published.model_copy(update={"measured": "other"}).to_json())
    bed.run("--changed")
    assert capsys.readouterr().out == "bed: changed since abc\n"
