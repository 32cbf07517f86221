"""One small fault in one source file."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Mutant:
    """A whole source with one fault in it, and the difference for people to read.

    `before` and `after` are the lines that differ, from `line` on, without their indentation and
    line ends; `within` is the function or class that contains them, empty at the top level.
    """

    file: str
    line: int
    within: str
    before: str
    after: str
    source: str

    @property
    def name(self) -> tuple[str, str, str, str]:
        """The identity that survives changes of other lines of the file."""
        return self.file, self.within, self.before, self.after

    def __str__(self) -> str:
        return f"{self.file}:{self.line} ({self.within}): {self.before} → {self.after or 'nothing'}"


def splice(file: str, source: str, within: str, span: tuple[int, int], new: str) -> Mutant:
    """Return the mutant in which `new` replaces the text between the places of `span`."""
    start, end = span
    first = source.rfind("\n", 0, start) + 1
    last = source.find("\n", end)
    last = len(source) if last < 0 else last
    return Mutant(
        file=file,
        line=source.count("\n", 0, start) + 1,
        within=within,
        before=_plain(source[first:last]),
        after=_plain(source[first:start] + new + source[end:last]),
        source=source[:start] + new + source[end:],
    )


def _plain(lines: str) -> str:
    return " ".join(lines.split())
