"""Runs cases of one suite in this process: the results are printed and kept, not published.

``python -m e2e.measure.command MODULE WORDS`` is how `e2e.measure.runner` starts each case. Exit
status: 0 if every goal is met; 1 if one is missed; 2 if something failed; 77 if this machine lacks
what a case needs and nothing else is wrong; 130 after Ctrl-C.
"""

from __future__ import annotations

import argparse
import os
import signal
import sys
import threading
import time
import traceback
from datetime import UTC, datetime
from difflib import get_close_matches
from fnmatch import fnmatchcase
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Final

from e2e.measure import machine
from e2e.measure.errors import MeasureError, NotRunError
from e2e.measure.results import Origin, Result, Results
from e2e.measure.suite import ROOT, digest
from e2e.measure.table import to_table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.measure.row import Row
    from e2e.measure.suite import Case, Suite

OUT: Final = ROOT / "e2e/out"
NOT_RUN: Final = 77
"""automake's exit status for a skipped test."""


def main(suite: Suite, words: Sequence[str] | None = None) -> int:
    arguments = parse(parser_of("python -m e2e.measure.command MODULE", suite.about), words)
    try:
        return run(suite, arguments)
    except MeasureError as error:
        print(f"{suite.name}: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


def parser_of(program: str, about: str) -> argparse.ArgumentParser:
    """Return the parser of the arguments that all measuring commands share."""
    parser = argparse.ArgumentParser(prog=program, description=about)
    parser.add_argument(
        "--only", nargs="+", action="extend", metavar="CASE", help="these; * and ? as in a shell"
    )
    number = parser.add_mutually_exclusive_group()
    number.add_argument("--n", type=int, help="so often, instead of each case's full number")
    number.add_argument("--quick", action="store_true", help="each case's small number")
    parser.add_argument(
        "--long", action="store_true", help="also the cases that take hours; they are not published"
    )
    parser.add_argument(
        "--out", type=Path, default=OUT, metavar="FOLDER", help="where the results go"
    )
    return parser


def parse(
    parser: argparse.ArgumentParser, words: Sequence[str] | None = None
) -> argparse.Namespace:
    arguments = parser.parse_args(words)
    if arguments.n is not None and arguments.n < 1:
        parser.error(f"--n {arguments.n}: at least 1")
    return arguments


def run(suite: Suite, arguments: argparse.Namespace) -> int:
    """Measure; return the exit status. Raises `MeasureError` if the arguments make no sense."""
    wanted = [
        (case, times(case, arguments))
        for _, case in chosen([suite], arguments.only, long=arguments.long)
    ]
    origin = origin_of(suite)
    results = Results(arguments.out / suite.name)
    load_1min = os.getloadavg()[0]
    found = []
    for case, n in wanted:
        print(f"{case.key} … ", end="", file=sys.stderr, flush=True)
        one = _measure(case, n, origin, load_1min, arguments.out / suite.name / "log.txt")
        if machine.commit() != origin.commit:
            raise MeasureError(f"the code is no longer that of {origin.commit}: not kept")
        results.add(one)
        print(f"{one.problem or 'ok'} ({one.took_s:.0f} s)", file=sys.stderr, flush=True)
        found.append(one)
    rows = suite.derive([row for result in found for row in result.rows])
    print(to_table(rows), flush=True)
    return _status(found, rows)


def origin_of(suite: Suite) -> Origin:
    return Origin(
        commit=machine.commit(), measured=digest(suite.measures), machine=machine.describe()
    )


def _measure(case: Case, n: int, origin: Origin, load_1min: float, log: Path) -> Result:
    started_utc, start_s = datetime.now(tz=UTC).isoformat(timespec="seconds"), time.monotonic()
    result = Result(
        case=case.key, n=n, origin=origin, started_utc=started_utc, took_s=0.0, load_1min=load_1min
    )
    try:
        update: dict[str, object] = {"rows": list(case.run(n))}
    except NotRunError as error:
        update = {"status": "not run", "problem": str(error)}
    except Exception as error:  # whatever it is, the other cases must not be lost
        with log.open("a", encoding="utf-8") as file:
            file.write(f"{started_utc} {case.key}\n{traceback.format_exc()}\n")
        is_told = isinstance(error, MeasureError | AssertionError)  # as `eventually` says it
        name = "" if is_told else f"{type(error).__name__}: "
        problem = name + (str(error).strip().splitlines() or [""])[0]
        update = {"status": "failed", "problem": problem}
    return result.model_copy(update=update | {"took_s": time.monotonic() - start_s})


def times(case: Case, arguments: argparse.Namespace) -> int:
    return int(arguments.n or (case.quick if arguments.quick else case.n))


def line(case: Case, n: int) -> str:
    """Describe a case: how often it measures, how long that takes, and what it asks."""
    minutes = f"{case.minutes_of(n):.1f} min" if case.minutes else ""
    return f"{case.key:<28}{n:>6}{minutes:>10}  {case.title}{' (long)' * case.long}"


def chosen(
    suites: Sequence[Suite], patterns: Sequence[str] | None, *, long: bool
) -> list[tuple[Suite, Case]]:
    """Return the cases that a pattern matches, or all; raises `MeasureError` if there are none."""
    every = [(suite, case) for suite in suites for case in suite.cases]
    keys = [case.key for _, case in every if long or not case.long]
    for pattern in patterns or ():
        if not any(fnmatchcase(key, pattern) for key in keys):
            if any(fnmatchcase(case.key, pattern) for _, case in every):
                raise MeasureError(f"{pattern} takes hours; add --long")
            near = get_close_matches(pattern, keys, 1)
            meant = f"; did you mean {near[0]}?" if near else ""
            raise MeasureError(f"there is no case {pattern}{meant} (--list names them)")
    return [
        (suite, case)
        for suite, case in every
        if case.key in keys
        and (not patterns or any(fnmatchcase(case.key, pattern) for pattern in patterns))
    ]


def _status(found: Sequence[Result], rows: Sequence[Row]) -> int:
    statuses = {result.status for result in found}
    if "failed" in statuses:
        return 2
    if "not run" in statuses:
        return NOT_RUN
    return 1 if any(row.met is False for row in rows) else 0


def _end_with_the_runner() -> None:
    """Stop, as by Ctrl-C, when the parent is gone: its end of the pipe closes then."""
    sys.stdin.read()
    # To the main thread, which may sleep: a signal handled by another thread does not wake it.
    signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)


if __name__ == "__main__":
    # A shell makes background programs ignore Ctrl-C, and children inherit that.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    threading.Thread(target=_end_with_the_runner, daemon=True).start()
    sys.exit(main(import_module(sys.argv[1]).SUITE, sys.argv[2:]))
