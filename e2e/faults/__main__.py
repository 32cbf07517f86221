"""``python -m e2e.faults``: JSON on standard output, a table for people on standard error.

Exit status: 0 when every goal is met; 1 when one is missed; 2 when something could not be measured.
"""

from __future__ import annotations

import argparse
import asyncio
import sys
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from playwright.async_api import Error as PlaywrightError

from e2e.bench import machine
from e2e.bench.errors import BenchError
from e2e.faults.errors import FaultError
from e2e.faults.plan import BY_NAME, FAULTS
from e2e.faults.report import Report, to_json, to_table

if TYPE_CHECKING:
    from e2e.faults.finding import Figure
    from e2e.faults.plan import Fault


async def measured(fault: Fault, n: int) -> list[Figure]:
    """Measure one fault; raises `FaultError` with a sentence, whatever went wrong."""
    try:
        found = await fault.measure(n)
    except (AssertionError, BenchError, OSError, PlaywrightError, TimeoutError) as error:
        raise FaultError(f"{fault.name}: {str(error) or type(error).__name__}") from error
    return found if isinstance(found, list) else [found]


def main() -> int:
    arguments = _arguments()
    started_utc, start_s = datetime.now(tz=UTC), time.monotonic()
    described = machine.describe()
    figures: list[Figure] = []
    problems: list[str] = []
    for fault in FAULTS:
        if arguments.only and fault.name not in arguments.only:
            continue
        print(f"{fault.name} …", file=sys.stderr, flush=True)
        try:
            # A loop for each: what one leaves behind must not disturb the next.
            figures += asyncio.run(measured(fault, arguments.n or fault.n))
        except FaultError as error:
            problems.append(str(error))
            print(f"  {error}", file=sys.stderr, flush=True)
    report = Report(
        started_utc=started_utc.isoformat(timespec="seconds"),
        took_s=time.monotonic() - start_s,
        machine=described,
        figures=figures,
        problems=problems,
    )
    print(to_table(report), file=sys.stderr)
    text = to_json(report)
    print(text)
    if arguments.json is not None:
        arguments.json.write_text(text + "\n", encoding="utf-8")
    if problems:
        return 2
    return 0 if report.all_met else 1


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m e2e.faults",
        description="Break each link from finger to wheel while the robot drives; time the stop.",
    )
    parser.add_argument(
        "--only", nargs="+", choices=BY_NAME, metavar="NAME", help=", ".join(BY_NAME)
    )
    parser.add_argument("--n", type=int, metavar="N", help="so often, instead of the full number")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the JSON there as well")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
