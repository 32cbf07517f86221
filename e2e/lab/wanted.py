"""What the command line asks for, as cells."""

from __future__ import annotations

from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import TYPE_CHECKING

from e2e.lab import goals, plan
from e2e.lab.errors import LabError

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.lab.cell import Cell


@dataclass(frozen=True, slots=True)
class Wanted:
    """Which plan, which part of it, how often, and where its results go."""

    quick: bool = False
    long: bool = False
    goals: bool = False
    only: list[str] = field(default_factory=list)
    repeats: int = 1
    out: Path | None = None

    @property
    def is_trimmed(self) -> bool:
        """Whether cells are left out so that the hour is kept, which nobody else has to keep."""
        return not (self.quick or self.long or self.goals or self.only)

    def cells(self) -> list[Cell]:
        """Plan them; raises `LabError` where a pattern matches none."""
        everything = self._planned([])
        for pattern in self.only:
            if not any(plan.matches(cell, [pattern]) for cell in everything):
                raise LabError(
                    f"no cell's name has {pattern} in it{_near(pattern, everything)}; "
                    "--list says their names"
                )
        return self._planned(self.only)

    def _planned(self, only: list[str]) -> list[Cell]:
        if self.quick:
            return plan.quick(repeats=self.repeats, only=only)
        if self.goals:
            return goals.planned(long=self.long, repeats=self.repeats, only=only)
        seconds = plan.LONG_SECONDS if self.long else plan.SECONDS
        return plan.full(seconds=seconds, repeats=self.repeats, only=only, trimmed=self.is_trimmed)


def _near(pattern: str, cells: list[Cell]) -> str:
    """Say which part of a name was meant, where one of them is close."""
    parts = sorted({part for cell in cells for part in cell.variant.split("/")})
    for word in pattern.split("/"):
        near = get_close_matches(word, parts, 1)
        if word not in parts and near:
            return f"; did you mean {near[0]}?"
    return ""
