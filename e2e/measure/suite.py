"""A suite: its cases, and the product's files that they measure."""

from __future__ import annotations

import ast
import asyncio
import hashlib
import io
import tokenize
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine, Sequence

    from e2e.measure.row import Row

ROOT: Final = Path(__file__).resolve().parents[2]
SERVER: Final = ("server/wax/**/*.py", "requirements.lock")
PAGE: Final = (
    *("web/src/**/*.ts", "web/src/**/*.tsx", "web/src/**/*.json"),
    *("web/vite.config.ts", "web/package-lock.json"),
)
FIRMWARE: Final = ("server/firmware/**/*.h", "server/firmware/**/*.cpp")
_BUILT: Final = {"generated", "dist", "node_modules"}


@dataclass(frozen=True, slots=True)
class Case:
    """`run(n)` measures `n` times and returns the rows; `n` in full, `quick` in the short form.

    It raises `NotRunError` if this machine cannot, anything else if it failed: either way the other
    cases continue. `minutes` is how long it takes in full. A `long` one runs only with ``--long``
    and is never published.
    """

    key: str
    title: str
    n: int
    run: Callable[[int], Sequence[Row]]
    quick: int = 1
    minutes: float = 0.0
    long: bool = False

    def minutes_of(self, n: int) -> float:
        return self.minutes * n / self.n


def measured(
    key: str,
    n: int,
    measure: Callable[[int], Coroutine[Any, Any, list[Row]]],
    title: str,
    quick: int,
    *,
    minutes: float = 0.0,
    long: bool = False,
) -> Case:
    return Case(key, title, n, lambda n: asyncio.run(measure(n)), quick, minutes, long)


@dataclass(frozen=True, slots=True)
class Suite:
    """`measures` are globs of the product's files; a change of these makes the results old.

    `columns` are the values of a row that its table shows, in order. `derive` makes the published
    rows from all cases' rows, for figures that compare cases or are medians over them.
    """

    name: str
    about: str
    measures: tuple[str, ...]
    columns: tuple[str, ...]
    cases: tuple[Case, ...]
    derive: Callable[[list[Row]], list[Row]] = list
    notes: tuple[str, ...] = ()
    """Notes for the table's reader, a sentence each."""


def digest(measures: Sequence[str], root: Path = ROOT) -> str:
    """Hash names and contents of the files that the globs match, without built files and tests.

    Of Python only the code counts: a reworded comment changes no figure.
    """
    found = hashlib.sha256()
    for path in sorted({path for glob in measures for path in root.glob(glob)}):
        name = path.relative_to(root)
        if not _BUILT.intersection(name.parts) and ".test." not in name.name:
            data = path.read_bytes()
            content = _what_runs(data) if path.suffix == ".py" else data
            found.update(f"{name.as_posix()}\n".encode() + content + b"\0")
    return found.hexdigest()[:16]


@cache
def _what_runs(source: bytes) -> bytes:
    """Return Python without comments, docstrings and empty lines.

    It cuts by positions in the source, because the output of `ast` differs between Pythons.
    """
    text = source.decode()
    lines = text.splitlines()
    for node in ast.walk(ast.parse(text)):
        match node:
            case ast.Expr(ast.Constant(str()), lineno=first, end_lineno=int(last)):
                lines[first - 1 : last] = [""] * (last - first + 1)
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            row, column = token.start
            lines[row - 1] = lines[row - 1][:column]
    return "\n".join(line.rstrip() for line in lines if line.strip()).encode()
