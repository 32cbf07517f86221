"""``python -m e2e.bench``: JSON on standard output, a table for people on standard error.

Exit status: 0 when everything asked for was measured, whether or not a goal was missed; 2 when
something could not be measured.
"""

from __future__ import annotations

import argparse
import sys
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from e2e.bench import fanout, first_picture, key_to_byte, machine, memory
from e2e.bench.errors import BenchError
from e2e.bench.goals import Results, Sides, goals
from e2e.bench.plan import FULL, QUICK
from e2e.bench.report import Report, to_json, to_table
from e2e.bench.servers import SIDES

if TYPE_CHECKING:
    from collections.abc import Callable

    from e2e.bench.plan import Plan
    from e2e.bench.servers import Side

T = TypeVar("T")

NAMES = ("fanout", "first_picture", "key_to_byte", "memory")


class Bench:
    """Measures what was asked for and keeps a sentence about each thing that failed."""

    def __init__(self, plan: Plan, names: list[str]) -> None:
        self._plan = plan
        self._names = names
        self.problems: list[str] = []

    def run(self) -> Results:
        return Results(
            fanout=self._both("fanout", fanout.measure),
            first_picture=self._both("first_picture", first_picture.measure),
            # The peer has no robot.
            key_to_byte=self._both("key_to_byte", key_to_byte.measure, ("ours",)),
            memory=self._both("memory", memory.measure),
        )

    def _both(
        self, name: str, measure: Callable[[Side, Plan], T], sides: tuple[Side, ...] = SIDES
    ) -> Sides[T]:
        found: Sides[T] = Sides()
        if name not in self._names:
            return found
        for side in sides:
            print(f"{name}, {side} …", file=sys.stderr, flush=True)
            try:
                result = measure(side, self._plan)
                setattr(found, side, result)
                # What was cut short is told as well as what failed altogether.
                if isinstance(result, fanout.FanOut) and result.problem is not None:
                    self._complain(name, side, result.problem)
            except BenchError as error:
                self._complain(name, side, str(error))
        return found

    def _complain(self, name: str, side: Side, problem: str) -> None:
        self.problems.append(f"{name}, {side}: {problem}")
        print(f"  {problem}", file=sys.stderr, flush=True)


def main() -> int:
    arguments = _arguments()
    plan = QUICK if arguments.quick else FULL
    started_utc, start_s = datetime.now(tz=UTC), time.monotonic()
    described = machine.describe()
    names = arguments.only or list(NAMES)
    bench = Bench(plan, names)
    results = bench.run()
    report = Report(
        started_utc=started_utc.isoformat(timespec="seconds"),
        took_s=time.monotonic() - start_s,
        quick=plan.quick,
        machine=described,
        goals=goals(results, names),
        measurements=results,
        problems=bench.problems,
    )
    print(to_table(report), file=sys.stderr)
    text = to_json(report)
    print(text)
    if arguments.out is not None:
        arguments.out.write_text(text + "\n", encoding="utf-8")
    return 2 if bench.problems else 0


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m e2e.bench",
        description="Measure WAX and a stock aiortc server, the same work on the same machine.",
    )
    parser.add_argument(
        "--only", action="append", choices=NAMES, metavar="NAME", help="|".join(NAMES)
    )
    parser.add_argument("--quick", action="store_true", help="under two minutes, rough figures")
    parser.add_argument("--out", type=Path, metavar="FILE", help="write the JSON there as well")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
