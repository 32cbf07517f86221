"""What a run writes while it goes on, so that a crash loses one cell and the rest can follow."""

from __future__ import annotations

import os
import shutil
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Self

from pydantic import BaseModel, ConfigDict, ValidationError

from e2e.lab.cell import Cell
from e2e.lab.errors import LabError
from e2e.lab.results import CellResult

if TYPE_CHECKING:
    from e2e.lab.results import Run

RUNS: Final = Path("e2e/out/lab")
PLAN: Final = "plan.json"
CELLS: Final = "cells.jsonl"
LOG: Final = "log.txt"
RUN: Final = "run.json"
REPORT: Final = "report.html"


class Begun(BaseModel):
    """What was wanted when the run began."""

    model_config = ConfigDict(extra="forbid")

    started_utc: str
    arguments: list[str]
    machine: dict[str, Any]
    cells: list[Cell]
    own_error: bool
    """Whether the instrument's own error is measured first."""
    strict: bool
    """Whether a cell without a picture is a failure of the run: on a link that can carry it."""
    instrument: dict[str, Any] = {}
    """That error, once it is known."""
    verify: bool = False
    """Whether the emulator is verified first."""
    emulator: list[dict[str, Any]] = []
    """What came of that, profile by profile."""

    def left(self, results: list[CellResult]) -> list[Cell]:
        """Return what is to be measured: what failed or was not run is tried again."""
        done = {result.cell.key for result in results if result.status == "ok"}
        return [cell for cell in self.cells if cell.key not in done]


class RunFolder:
    """One run's folder. All that writes raises `LabError` where the disk does not take it."""

    def __init__(self, path: Path, begun: Begun) -> None:
        self.path = path
        self.begun = begun

    @classmethod
    def create(cls, path: Path | None, begun: Begun) -> Self:
        """Make the folder, by default one that is named by the time.

        Raises `LabError` where it cannot be made or holds a run already.
        """
        path = path or RUNS / datetime.now(tz=UTC).strftime("%Y-%m-%d-%H%M%S")
        if (path / PLAN).exists():
            raise LabError(f"{path} holds a run already; name another folder, or --resume {path}")
        folder = cls(path, begun)
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise _unwritable(path, error) from error
        folder.save()
        return folder

    @classmethod
    def unfinished(cls, path: Path | None) -> Self:
        """Find the run to continue: this one, or the newest that did not end.

        One that did end has something left where cells failed or were not run. Raises `LabError`
        where there is none, or nothing is left.
        """
        if path is None:
            found = [plan.parent for plan in RUNS.glob(f"*/{PLAN}")]
            unfinished = sorted(run for run in found if not (run / RUN).exists())
            if not unfinished:
                raise LabError(f"there is no unfinished run in {RUNS}; begin one without --resume")
            path = unfinished[-1]
        try:
            begun = Begun.model_validate_json((path / PLAN).read_bytes())
        except OSError as error:
            raise LabError(
                f"{path} holds no run ({error.strerror}); name the folder of one"
            ) from error
        except ValidationError as error:
            raise LabError(
                f"{path / PLAN} was written by another version of the lab; begin a new run"
            ) from error
        folder = cls(path, begun)
        folder._cut_torn_line()
        if (path / RUN).exists() and not begun.left(folder.results()):
            raise LabError(
                f"the run in {path} is finished and no cell of it failed; its figures are in "
                f"{path / RUN}, and python -m e2e.lab.report {path / RUN} makes the page of them"
            )
        return folder

    def save(self) -> None:
        """Write what was wanted."""
        self._replace(PLAN, self.begun.model_dump_json(indent=1))

    def results(self) -> list[CellResult]:
        """Read the cells that are finished, in the order in which they first were.

        Of one that was measured again the last time counts.
        """
        try:
            lines = (self.path / CELLS).read_bytes().splitlines()
        except FileNotFoundError:
            return []
        results = map(CellResult.model_validate_json, lines)
        return list({result.cell.key: result for result in results}.values())

    def add(self, result: CellResult) -> None:
        """Keep a finished cell; it is on the disk on return."""
        try:
            with (self.path / CELLS).open("ab") as file:
                file.write(result.model_dump_json().encode() + b"\n")
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise _unwritable(self.path, error) from error

    def log(self, text: str) -> None:
        """Keep what is too long for one sentence."""
        try:
            with (self.path / LOG).open("a", encoding="utf-8") as file:
                file.write(f"{utc()} {text.rstrip()}\n")
        except OSError as error:
            raise _unwritable(self.path, error) from error

    def files_of(self, cell: Cell) -> Path:
        """Give the systems of a cell a folder for their own files."""
        path = self._files / cell.key.replace("/", "-")
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise _unwritable(path, error) from error
        return path

    def drop_files_of(self, cell: Cell) -> None:
        """Take them away again: of a cell that went well nobody reads them."""
        shutil.rmtree(self.files_of(cell), ignore_errors=True)
        with suppress(OSError):  # others have left theirs
            self._files.rmdir()

    @property
    def _files(self) -> Path:
        return self.path / "files"

    def finish(self, run: Run) -> None:
        """Write the whole run."""
        self._replace(RUN, run.model_dump_json())

    def _replace(self, name: str, text: str) -> None:
        """Write a file that is there whole or not at all."""
        part = self.path / f"{name}.part"
        try:
            part.write_text(text, encoding="utf-8")
            part.replace(self.path / name)
        except OSError as error:
            raise _unwritable(self.path, error) from error

    def _cut_torn_line(self) -> None:
        """Take away the half of a line that a crash left."""
        path = self.path / CELLS
        if not path.exists():
            return
        text = path.read_bytes()
        try:
            os.truncate(path, text.rfind(b"\n") + 1)
            self.results()
        except OSError as error:
            raise _unwritable(self.path, error) from error
        except ValidationError as error:
            raise LabError(
                f"{path} was written by another version of the lab; begin a new run"
            ) from error


def utc() -> str:
    """Return the time as the results have it."""
    return datetime.now(tz=UTC).isoformat(timespec="seconds")


def _unwritable(path: Path, error: OSError) -> LabError:
    return LabError(
        f"the lab cannot write to {path} ({error.strerror or error}); name another by --out FOLDER"
    )
