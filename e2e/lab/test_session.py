"""What a run does beside its cells: the emulator before them, the page after them."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import pytest

from e2e.lab import session
from e2e.lab.cell import Cell
from e2e.lab.errors import LabError
from e2e.lab.folder import LOG, REPORT, Begun, RunFolder
from e2e.lab.progress import Progress
from e2e.lab.report.synthetic import measured, run

if TYPE_CHECKING:
    from pathlib import Path

CELL = Cell(experiment="E1", profile="lan", system="stock")


def _folder(path: Path) -> RunFolder:
    begun = Begun(
        started_utc="", arguments=[], machine={}, cells=[CELL], own_error=False, strict=True
    )
    return RunFolder.create(path / "run", begun)


def test_a_page_that_fails_says_how_to_make_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An error of any kind in the report is one sentence with the command; the log has the rest."""

    def broken(*_: Any) -> None:
        raise ZeroDivisionError("float division by zero")

    monkeypatch.setattr(session, "write", broken)
    folder = _folder(tmp_path)
    said = r"ZeroDivisionError.*python -m e2e\.lab\.report .*run\.json"
    with pytest.raises(LabError, match=said):
        session.write_report(run([measured(CELL)]), folder)
    assert "Traceback" in (folder.path / LOG).read_text()


def test_a_page_that_cannot_be_written_says_so(tmp_path: Path) -> None:
    """Where its place is taken the sentence says why, and how to make it elsewhere."""
    folder = _folder(tmp_path)
    (folder.path / REPORT).mkdir()
    with pytest.raises(LabError, match=r"Is a directory.*python -m e2e\.lab\.report"):
        session.write_report(run([measured(CELL)]), folder)


async def test_each_profile_is_verified_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Who continues a run verifies what is left of its profiles; what is known is on the disk."""
    asked: list[str] = []

    async def verified(profile: str) -> dict[str, Any]:
        asked.append(profile)
        return {"profile": profile, "ok": True}

    monkeypatch.setattr(session, "verified", verified)
    folder = _folder(tmp_path)
    cells = [CELL.model_copy(update={"profile": name}) for name in ("lan", "campus", "lan")]
    folder.begun.cells = cells
    folder.begun.emulator = [{"profile": "campus", "ok": False}]
    await session.verify_emulator(folder, Progress(cells, io.StringIO()))
    assert asked == ["lan"]
    found = RunFolder.unfinished(folder.path).begun.emulator
    assert [(one["profile"], one["ok"]) for one in found] == [("campus", False), ("lan", True)]
