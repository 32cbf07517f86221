"""A suite for the tests of the measuring tools: files in the folder BED say what its cases do."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Final

from e2e.measure.row import judged
from e2e.measure.suite import Case, Suite

if TYPE_CHECKING:
    from collections.abc import Callable

    from e2e.measure.row import Row


def _case(key: str) -> Callable[[int], list[Row]]:
    def measure(n: int) -> list[Row]:
        folder = Path(os.environ["BED"])
        with (folder / "runs").open("a", encoding="utf-8") as file:
            file.write(f"{key} {n}\n")
        match (folder / key).read_text(encoding="utf-8") if (folder / key).exists() else "":
            case "fails":
                raise OSError("no board")
            case "hangs":
                time.sleep(60)
            case "moves":
                (folder / "commit").write_text("def", encoding="utf-8")
        return [judged(key, key, "ms", {"WAX": 1.0}, 2.0, n=n)]

    return measure


SUITE: Final = Suite(
    "bed",
    "A test bed.",
    ("README.md",),
    ("WAX",),
    (
        Case("one", "runs", 10, _case("one")),
        Case("two", "runs", 10, _case("two"), minutes=1),
        Case("hours", "runs", 10, _case("hours"), long=True),
    ),
)
