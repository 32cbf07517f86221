"""Results as they arrive, a line each: an interrupted run loses one case and can be resumed."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, Literal

from pydantic import BaseModel, ConfigDict, ValidationError

from e2e.measure.machine import Machine
from e2e.measure.row import Row

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


class Origin(BaseModel):
    """What a result was measured on. `measured` is the hash of the product's files."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    commit: str
    measured: str
    machine: Machine


class Result(BaseModel):
    """One case. `problem` is a sentence if there are no rows; `load_1min` is the load before."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    case: str
    n: int
    origin: Origin
    started_utc: str
    took_s: float
    load_1min: float
    status: Literal["ok", "failed", "not run"] = "ok"
    problem: str | None = None
    rows: list[Row] = []


class Results:
    """A suite's file of results; those of another commit stay in it but do not count."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "results.jsonl"
        folder.mkdir(parents=True, exist_ok=True)

    def add(self, result: Result) -> None:
        with self.path.open("a", encoding="utf-8") as file:
            # The newline comes first, so that a line torn by a crash does not spoil the next.
            file.write(f"\n{result.model_dump_json()}")

    def of(self, origin: Origin) -> dict[tuple[str, int], Result]:
        """Return the results that count for this origin, the newest of each case and n."""
        return {(one.case, one.n): one for one in self._every() if one.origin == origin}

    def newest(self) -> list[Result]:
        """Return the newest result, and those that count together with it."""
        every = list(self._every())
        return list(self.of(every[-1].origin).values()) if every else []

    def _every(self) -> Iterator[Result]:
        for line in self.path.read_text("utf-8").splitlines() if self.path.exists() else ():
            with suppress(ValidationError):  # torn by a crash, or written by another version
                yield Result.model_validate_json(line)
