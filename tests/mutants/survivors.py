"""The mutants that no test can catch, each with the reason."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from tests.mutants.record import Outcome

LIST: Final = Path(__file__).with_name("survivors.toml")


@dataclass(frozen=True, slots=True)
class Survivor:
    """An entry of the list: `line` becomes `becomes` in the function `within`."""

    file: str
    within: str
    line: str
    becomes: str
    reason: str

    @property
    def name(self) -> tuple[str, str, str, str]:
        return self.file, self.within, self.line, self.becomes


def read(path: Path = LIST) -> list[Survivor]:
    """Read the list; raises `ValueError` if an entry has no reason or is there twice."""
    entries = tomllib.loads(path.read_text(encoding="utf-8")).get("survivor", [])
    found = [Survivor(**entry) for entry in entries]
    for one in found:
        if not one.reason.strip():
            raise ValueError(f"{one.file}: “{one.line}” is listed without a reason")
    if len({one.name for one in found}) < len(found):
        raise ValueError("a survivor is listed twice")
    return found


def unlisted(survived: list[Outcome], listed: list[Survivor]) -> list[Outcome]:
    """Return the survivors that are not listed."""
    names = {one.name for one in listed}
    return [one for one in survived if one.name not in names]


def outdated(outcomes: list[Outcome], survived: list[Outcome], listed: list[Survivor]) -> list[str]:
    """Return the entries for tested files that match no survivor any more."""
    tested = {one.file for one in outcomes}
    names = {one.name for one in survived}
    return [
        f"{one.file} ({one.within}): {one.line} → {one.becomes}"
        for one in listed
        if one.file in tested and one.name not in names
    ]
