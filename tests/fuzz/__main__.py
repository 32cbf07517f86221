"""``python -m tests.fuzz``: the command line of `e2e.measure.command`, for the search.

A million inputs for each parser, or twenty minutes. What fails becomes a file of the corpus.
"""

from __future__ import annotations

import sys
from functools import partial
from typing import TYPE_CHECKING, Final

from e2e.measure.command import main
from e2e.measure.row import Row, counted
from e2e.measure.suite import FIRMWARE, ROOT, SERVER, Case, Suite
from tests.fuzz.plan import TARGETS
from tests.fuzz.search import LONGEST_S, search

if TYPE_CHECKING:
    from tests.fuzz.target import Target

_INPUTS: Final = 1_000_000
_QUICK: Final = 20_000
_TRACE_LINES: Final = 12


def _try(target: Target, n: int) -> list[Row]:
    found = search(target, n)
    detail: dict[str, object] = {}
    if found.failed is not None:
        detail["input"] = str(found.failed.relative_to(ROOT))
        detail["why"] = "\n".join(found.report.strip().splitlines()[:_TRACE_LINES])
    row = counted(
        f"fuzz: {target.name}",
        f"{target.what}: inputs neither a value nor refused, or dear, or that move the robot",
        int(found.failed is not None),
        found.inputs,
        **detail,
    )
    is_whole = found.inputs >= n or found.took_s >= LONGEST_S
    return [row.model_copy(update={"met": row.met and is_whole})]


SUITE: Final = Suite(
    name="fuzz",
    about="Search for bytes that a parser neither understands nor refuses, led by coverage.",
    measures=(*SERVER, *FIRMWARE, "tests/fuzz/**/*.py"),
    columns=("max",),
    cases=tuple(
        Case(name, target.what, _INPUTS, partial(_try, target), _QUICK)
        for name, target in TARGETS.items()
    ),
    notes=("A million inputs for each parser, or 20 minutes, led by coverage (atheris).",),
)

if __name__ == "__main__":
    sys.exit(main(SUITE))
