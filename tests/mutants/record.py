"""The outcome of each mutant, kept line by line, so that an interrupted run can be resumed."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from tests.mutants.mutant import Mutant
    from tests.mutants.plan import Target

KILLED, NEVER_ENDED, SURVIVED, NONE = "killed", "never ended", "survived", "none"
"""Caught by the tests; never ended; not caught; no fault; or no program."""

_EVIDENCE: Final = (
    "server/wax/control",
    "server/wax/driver",
    "server/wax/robot",
    "server/firmware",
)
_READ: Final = {".py", ".json", ".h", ".cpp"}


@dataclass(frozen=True, slots=True)
class Outcome:
    """`digest` identifies the faulty source, `evidence` everything else that it was tested with."""

    file: str
    line: int
    within: str
    before: str
    after: str
    outcome: str
    took_s: float
    digest: str
    evidence: str

    @property
    def name(self) -> tuple[str, str, str, str]:
        return self.file, self.within, self.before, self.after

    def __str__(self) -> str:
        return f"{self.file}:{self.line} ({self.within}): {self.before} → {self.after or 'nothing'}"


class Record:
    """The outcomes in a file. An old one counts if nothing has changed.

    With `trusts_kills` a mutant that was caught once counts as caught: right after tests were
    added, wrong after some were removed.
    """

    def __init__(self, path: Path, *, trusts_kills: bool) -> None:
        self._path = path
        self._trusts_kills = trusts_kills
        self._known: dict[str, Outcome] = {}
        path.parent.mkdir(parents=True, exist_ok=True)
        for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
            old = Outcome(**json.loads(line))
            self._known[old.digest] = old

    def find(self, mutant: Mutant, evidence: str) -> Outcome | None:
        """Return the outcome of a mutant, if it still holds."""
        old = self._known.get(digest(mutant))
        if old is None or old.name != mutant.name:
            return None
        if old.evidence != evidence and not (self._trusts_kills and old.outcome != SURVIVED):
            return None
        return Outcome(**(asdict(old) | {"line": mutant.line}))

    def add(self, mutant: Mutant, outcome: str, took_s: float, evidence: str) -> Outcome:
        new = Outcome(
            *(mutant.file, mutant.line, mutant.within, mutant.before, mutant.after),
            outcome,
            round(took_s, 2),
            digest(mutant),
            evidence,
        )
        self._known[new.digest] = new
        with self._path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(asdict(new), ensure_ascii=False) + "\n")
        return new


def digest(mutant: Mutant) -> str:
    return hashlib.sha256(f"{mutant.file}\n{mutant.source}".encode()).hexdigest()[:24]


def evidence_of(target: Target, tree: Path) -> str:
    """Return a hash of a target's tests, and of everything else that they read."""
    found = hashlib.sha256(repr(target.tests).encode())
    folders = [(tree / folder).rglob("*") for folder in _EVIDENCE]
    beside = (tree / target.file).parent
    folders += [beside.glob("*"), *((tree / folder).glob("*") for folder in target.test_folders)]
    for path in sorted({path for paths in folders for path in paths}):
        name = path.relative_to(tree).as_posix()
        if path.suffix in _READ and name != target.file:
            found.update(f"{name}\n".encode() + path.read_bytes())
    return found.hexdigest()[:24]


def to_table(outcomes: Iterable[Outcome]) -> str:
    """Return how many mutants were caught, file by file."""
    by_file: dict[str, Counter[str]] = {}
    for one in outcomes:
        by_file.setdefault(one.file, Counter())[one.outcome] += 1
    rows = [(file.removeprefix("server/"), counts) for file, counts in by_file.items()]
    rows.append(("all", sum((counts for _, counts in rows), Counter())))
    lines = [f"{'':45}{'faults':>8}{'noticed':>9}{'survived':>10}{'share':>9}"]
    for name, counts in rows:
        noticed, survived = counts[KILLED] + counts[NEVER_ENDED], counts[SURVIVED]
        of = f"{noticed / (noticed + survived):9.1%}" if noticed + survived else f"{'–':>9}"
        lines.append(f"{name:45}{noticed + survived:8}{noticed:9}{survived:10}{of}")
    return "\n".join(lines)
