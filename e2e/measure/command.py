"""The command line of every suite.

Exit status: 0 when every goal is met; 1 when one is missed; 2 when something failed; 77 when this
machine lacks what a case needs and nothing else is wrong; 130 after Ctrl-C.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
import traceback
from datetime import UTC, datetime
from difflib import get_close_matches
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Final

from e2e.measure import machine
from e2e.measure.errors import MeasureError, NotRunError
from e2e.measure.published import FOLDER, publish
from e2e.measure.results import Origin, Result, Results
from e2e.measure.suite import ROOT, digest
from e2e.measure.table import to_table

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from e2e.measure.row import Row
    from e2e.measure.suite import Case, Suite

OUT: Final = ROOT / "e2e/out"
NOT_RUN: Final = 77
"""automake's exit status for a skipped test."""


def main(
    suite: Suite,
    words: Sequence[str] | None = None,
    *,
    out: Path = OUT,
    published: Path = FOLDER,
) -> int:
    """Carry out the command line; results go to the suite's own folder in `out`."""
    parser = parser_of(suite)
    arguments = parser.parse_args(words)
    if arguments.n is not None and arguments.n < 1:
        parser.error(f"--n {arguments.n}: at least 1")
    if arguments.publish and (arguments.quick or arguments.n):
        parser.error("only the full number is published; give --publish without --quick and --n")
    try:
        return run(suite, arguments, out=out, published=published)
    except MeasureError as error:
        print(f"{suite.name}: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


def parser_of(suite: Suite) -> argparse.ArgumentParser:
    """Return the parser, to which a suite may add options of its own."""
    parser = argparse.ArgumentParser(prog=f"python -m e2e.{suite.name}", description=suite.about)
    parser.add_argument(
        "--only", nargs="+", action="extend", metavar="CASE", help="these; * and ? as in a shell"
    )
    number = parser.add_mutually_exclusive_group()
    number.add_argument("--n", type=int, help="so often, instead of each case's full number")
    number.add_argument("--quick", action="store_true", help="each case's small number")
    parser.add_argument(
        "--resume", action="store_true", help="only what has no result of this product and machine"
    )
    parser.add_argument(
        "--long", action="store_true", help="also the cases that take hours; they are not published"
    )
    parser.add_argument("--list", action="store_true", help="say which cases there are")
    parser.add_argument(
        "--publish", action="store_true", help=f"then write {FOLDER.relative_to(ROOT)}/"
    )
    return parser


def run(
    suite: Suite, arguments: argparse.Namespace, out: Path = OUT, published: Path = FOLDER
) -> int:
    """Measure; the exit status. Raises `MeasureError` where what was asked for makes no sense."""
    wanted = [
        (case, arguments.n or (case.quick if arguments.quick else case.n))
        for case in _chosen(suite, arguments.only, long=arguments.long)
    ]
    if arguments.list:
        print("\n".join(_line(case, n) for case, n in wanted))
        return 0
    origin = Origin(
        commit=machine.commit(), measured=digest(suite.measures), machine=machine.describe()
    )
    if arguments.publish and origin.commit.endswith("-dirty"):
        raise MeasureError("what is not committed is not published; commit it first")
    results = Results(out / suite.name)
    kept = results.of(origin) if arguments.resume else {}
    load_1min = os.getloadavg()[0]
    found = []
    for number, (case, n) in enumerate(wanted, 1):
        old = kept.get((case.key, n))
        if old is None or old.status != "ok":
            print(f"[{number}/{len(wanted)}] {case.key} … ", end="", file=sys.stderr, flush=True)
            old = _measure(case, n, origin, load_1min, out / suite.name / "log.txt")
            results.add(old)
            print(f"{old.problem or 'ok'} ({old.took_s:.0f} s)", file=sys.stderr, flush=True)
        found.append(old)
    rows = suite.derive([row for result in found for row in result.rows])
    print(to_table(rows))
    if arguments.publish:
        everything = results.of(origin)
        full = [everything.get((case.key, case.n)) for case in suite.cases]
        path = publish(suite, [result for result in full if result], published)
        print(f"published: {path}; now run make figures")
    return _status(found, rows)


def _measure(case: Case, n: int, origin: Origin, load_1min: float, log: Path) -> Result:
    started_utc, start_s = datetime.now(tz=UTC).isoformat(timespec="seconds"), time.monotonic()
    result = Result(
        case=case.key, n=n, origin=origin, started_utc=started_utc, took_s=0.0, load_1min=load_1min
    )
    try:
        update: dict[str, object] = {"rows": list(case.run(n))}
    except NotRunError as error:
        update = {"status": "not run", "problem": str(error)}
    except Exception as error:  # whatever it is, the other cases are not to be lost
        with log.open("a", encoding="utf-8") as file:
            file.write(f"{started_utc} {case.key}\n{traceback.format_exc()}\n")
        name = "" if isinstance(error, MeasureError) else f"{type(error).__name__}: "
        problem = name + (str(error).strip().splitlines() or [""])[0]
        update = {"status": "failed", "problem": problem}
    return result.model_copy(update=update | {"took_s": time.monotonic() - start_s})


def _line(case: Case, n: int) -> str:
    """Say of a case how often it measures, how long that takes in full, and what it asks."""
    minutes = f"{case.minutes:.0f} min" if case.minutes else ""
    return f"{case.key:<28}{n:>6}{minutes:>9}  {case.title}{' (long)' * case.long}"


def _chosen(suite: Suite, patterns: Sequence[str] | None, *, long: bool) -> list[Case]:
    """Return the cases that a pattern matches, all without one."""
    cases = [case for case in suite.cases if long or not case.long]
    keys = [case.key for case in cases]
    for pattern in patterns or ():
        if not any(fnmatchcase(key, pattern) for key in keys):
            near = get_close_matches(pattern, keys, 1)
            meant = f"; did you mean {near[0]}?" if near else ""
            raise MeasureError(f"there is no case {pattern}{meant} (--list names them)")
    return [
        case
        for case in cases
        if not patterns or any(fnmatchcase(case.key, pattern) for pattern in patterns)
    ]


def _status(found: Sequence[Result], rows: Sequence[Row]) -> int:
    statuses = {result.status for result in found}
    if "failed" in statuses:
        return 2
    if "not run" in statuses:
        return NOT_RUN
    return 1 if any(row.met is False for row in rows) else 0
