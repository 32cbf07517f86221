"""``python -m e2e.mutants``: what is noticed, file by file, and what is not.

Exit status: 0 when enough is noticed and every survivor is listed with its reason; 1 when not;
2 when the tests fail without any fault.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Final

from e2e.mutants import cpp_faults, python_faults, survivors
from e2e.mutants.fork_server import open_fork_server
from e2e.mutants.plan import ACCEPTED, ROOT, TARGETS
from e2e.mutants.record import KILLED, NEVER_ENDED, NONE, SURVIVED, Record, to_table
from e2e.mutants.trial import Bench, TrialError

if TYPE_CHECKING:
    from e2e.mutants.mutant import Mutant
    from e2e.mutants.plan import Target
    from e2e.mutants.record import Outcome

_KEPT: Final = ROOT / "e2e/out/mutants.jsonl"


def mutants_of(target: Target, tree: Path) -> list[Mutant]:
    source = (tree / target.file).read_text(encoding="utf-8")
    faults = cpp_faults.faults if target.is_cpp else python_faults.faults
    return faults(target.file, source)


def main() -> int:
    arguments = _arguments()
    targets = [one for one in TARGETS if any(name in one.file for name in arguments.only or [""])]
    record = Record(arguments.record, trusts_kills=arguments.trust_kills)
    start_s = time.monotonic()
    outcomes: list[Outcome] = []
    with open_fork_server() as server, tempfile.TemporaryDirectory(prefix="wax-mutants-") as folder:
        bench = Bench(server, record, Path(folder), jobs=arguments.jobs)
        for target in targets:
            print(f"{target.file} …", file=sys.stderr, flush=True)
            try:
                found = bench.try_all(target, mutants_of(target, server.tree))
            except TrialError as error:
                print(f"wax: {error}", file=sys.stderr)
                return 2
            for one in found:
                if one.outcome == SURVIVED:
                    print(f"  {one}", file=sys.stderr, flush=True)
            outcomes += found
    print(f"{to_table(outcomes)}\n{(time.monotonic() - start_s) / 60:.1f} min")
    return _judge(outcomes)


def _judge(outcomes: list[Outcome]) -> int:
    """Say what is missing; gives the exit status."""
    listed = survivors.read()
    survived = [one for one in outcomes if one.outcome == SURVIVED]
    noticed = sum(one.outcome in {KILLED, NEVER_ENDED} for one in outcomes)
    faults = sum(one.outcome != NONE for one in outcomes)
    problems = [f"survived, and is not listed: {o}" for o in survivors.unlisted(survived, listed)]
    problems += [
        f"is listed, and does not survive: {o}"
        for o in survivors.outdated(outcomes, survived, listed)
    ]
    if noticed < ACCEPTED * faults:
        problems.append(f"only {noticed} of {faults} are noticed, which is under {ACCEPTED:.0%}")
    for problem in problems:
        print(problem)
    return 1 if problems else 0


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m e2e.mutants",
        description="Put small faults into what keeps the robot standing; the tests must notice.",
    )
    parser.add_argument("--only", nargs="+", metavar="PART", help="files with this in their path")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, metavar="N")
    parser.add_argument("--record", type=Path, default=_KEPT, metavar="FILE", help="kept there")
    parser.add_argument(
        "--trust-kills", action="store_true", help="after tests were added: the survivors only"
    )
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
