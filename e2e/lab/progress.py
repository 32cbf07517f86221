"""What the person at the terminal sees: which cell, how it went, what is left."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, TextIO

from e2e.lab.plan import cell_s, estimate_s

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.lab.cell import Cell
    from e2e.lab.results import CellResult


class Progress:
    """One line for each cell; what is left is the plan's estimate, held against how it went."""

    def __init__(
        self, cells: Sequence[Cell], out: TextIO | None = None, *, before: int = 0
    ) -> None:
        self._cells = cells
        self._out = out or sys.stderr
        self._before = before
        self._done = 0
        self._run: list[CellResult] = []
        self._told: set[str] = set()

    def begin(self, cell: Cell) -> None:
        number, of = self._before + self._done + 1, self._before + len(self._cells)
        self._write(f"[{number:{len(str(of))}}/{of}] {cell.variant}{_repeat(cell)} … ")

    def end(self, result: CellResult) -> None:
        self._done += 1
        if result.status != "not run":
            self._run.append(result)
        left = f", about {duration(self.left_s())} left" if self._done < len(self._cells) else ""
        self._write(f"{self._words(result)} {result.took_s:.0f} s{left}\n")

    def say(self, sentence: str) -> None:
        self._write(f"{sentence}\n")

    def left_s(self) -> float:
        """Return how long the rest will take; cells that were not run say nothing about it."""
        expected_s = sum(cell_s(result.cell) for result in self._run)
        took_s = sum(result.took_s for result in self._run)
        pace = min(2.0, max(0.5, took_s / expected_s)) if self._run else 1.0
        return pace * estimate_s(self._cells[self._done :])

    def _words(self, result: CellResult) -> str:
        if result.status == "ok":
            return "ok"
        problem = result.problem or ""
        if result.status == "not run" and problem in self._told:
            return "not run"
        self._told.add(problem)
        return f"{result.status}: {problem}"

    def _write(self, text: str) -> None:
        self._out.write(text)
        self._out.flush()


def count(cells: Sequence[Cell]) -> str:
    """Say how many they are."""
    return f"{len(cells)} cell{'' if len(cells) == 1 else 's'}"


def duration(seconds: float) -> str:
    """Say it as a person would: whole minutes, or seconds where there is no minute."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    if seconds < 90 * 60:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"


def _repeat(cell: Cell) -> str:
    return f", repetition {cell.repeat + 1}" if cell.repeat else ""
