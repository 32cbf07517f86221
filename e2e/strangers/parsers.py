"""A coverage-guided search for bytes that a parser neither parses nor refuses (`tests/fuzz`)."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import TYPE_CHECKING, Final

from tests.fuzz.plan import TARGETS
from tests.fuzz.search import LONGEST_S, Searched, search

from e2e.measure.row import Row, counted
from e2e.measure.suite import ROOT

if TYPE_CHECKING:
    from tests.fuzz.target import Target

_TRACE_LINES: Final = 12


def parsers(n: int) -> list[Row]:
    """Try `n` inputs on each parser, with as many parsers at once as there are cores."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        found = list(pool.map(partial(search, inputs=n), TARGETS.values()))
    return [_judged("parsers", f"{len(found)} parsers", found, n)]


def parser(target: Target, n: int) -> list[Row]:
    """Try `n` inputs on one parser, or as many as 20 minutes allow."""
    return [_judged(f"fuzz-{target.name}", target.what, [search(target, n)], n)]


def _judged(key: str, what: str, found: list[Searched], n: int) -> Row:
    failed = {
        str(one.failed.relative_to(ROOT)): one.report.strip().splitlines()[:_TRACE_LINES]
        for one in found
        if one.failed is not None
    }
    what = f"{what}: inputs neither a value nor refused, or dear, or that move the robot"
    row = counted(key, what, len(failed), sum(one.inputs for one in found), **failed)
    is_whole = all(one.inputs >= n or one.took_s >= LONGEST_S for one in found)
    return row.model_copy(update={"met": row.met and is_whole})
