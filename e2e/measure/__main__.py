"""``make measure``: all that is published, and the tables; it resumes where it was stopped.

Exit status: as of `e2e.measure.command`.
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from e2e.measure import machine
from e2e.measure.command import line, parse, parser_of
from e2e.measure.errors import MeasureError
from e2e.measure.published import FOLDER, everything
from e2e.measure.render import render
from e2e.measure.runner import SUITES, loaded, measure, planned, publish_complete
from e2e.measure.suite import ROOT

if TYPE_CHECKING:
    import argparse
    from collections.abc import Mapping, Sequence
    from pathlib import Path


def main(
    words: Sequence[str] | None = None,
    *,
    suites: Mapping[str, str] = SUITES,
    published: Path = FOLDER,
    readme: Path = ROOT / "README.md",
) -> int:
    """Run the command line; `suites` are modules by their suite's name."""
    arguments = parse(_parser(suites), words)
    try:
        return _carried_out(arguments, suites, published, readme)
    except MeasureError as error:
        print(f"measure: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("measure: what was measured is kept; the same words go on", file=sys.stderr)
        return 130


def _carried_out(
    arguments: argparse.Namespace, suites: Mapping[str, str], published: Path, readme: Path
) -> int:
    if arguments.render:
        render(published, readme)
        return 0
    if arguments.changed:
        changed = [one for one in everything(published) if one.is_changed]
        for one in changed:
            print(f"{one.suite}: changed since {one.commit}")
        return 0
    found = loaded(arguments.suites, suites)
    publishes = not (arguments.only or arguments.n or arguments.quick or arguments.long)
    if publishes and not arguments.list and machine.commit().endswith("-dirty"):
        raise MeasureError(
            "what is not committed is not published; commit it, or choose by --only or --quick"
        )
    tasks = planned(found, arguments)
    if arguments.list:
        for task in tasks:
            print(f"{task.suite.name:<14}{line(task.case, task.n)}")
        print(f"{len(tasks)} cases, {sum(task.minutes for task in tasks):.0f} min")
        return 0
    status = measure(tasks, arguments.out)
    if publishes and publish_complete(list(found.values()), arguments.out, published):
        render(published, readme)
    return status


def _parser(suites: Mapping[str, str]) -> argparse.ArgumentParser:
    parser = parser_of("python -m e2e.measure", "Measure, and publish what is complete.")
    parser.add_argument("suites", nargs="*", choices=[[], *suites], metavar="SUITE",
                        help=f"of {', '.join(suites)}; all without one")  # fmt: skip
    parser.add_argument("--list", action="store_true", help="say which cases there are")
    parser.add_argument(
        "--again", action="store_true", help="also what has a result of this commit and machine"
    )
    parser.add_argument(
        "--changed", action="store_true", help="only say which suites' measured files have changed"
    )
    parser.add_argument("--render", action="store_true", help="only set the tables anew")
    return parser


if __name__ == "__main__":
    sys.exit(main())
