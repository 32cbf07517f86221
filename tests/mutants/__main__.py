"""``python -m tests.mutants``: which mutants the tests catch, file by file, and which not.

Exit status: 0 if enough are caught and every survivor is listed with its reason; 1 if not; 2 if the
tests fail without any fault.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Final

from tests.mutants import cpp_faults, python_faults, survivors
from tests.mutants.fork_server import open_fork_server
from tests.mutants.plan import ACCEPTED, ROOT, TARGETS
from tests.mutants.record import KILLED, NEVER_ENDED, NONE, SURVIVED, Record, to_table
from tests.mutants.trial import Bench, TrialError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from tests.mutants.mutant import Mutant
    from tests.mutants.plan import Target
    from tests.mutants.record import Outcome

_PLAN: Final = "tests/mutants/plan.py"
KEPT: Final = ROOT / "e2e/out/mutants.jsonl"


def mutants_of(target: Target) -> list[Mutant]:
    source = (ROOT / target.file).read_text(encoding="utf-8")
    faults = cpp_faults.faults if target.is_cpp else python_faults.faults
    return faults(target.file, source)


def tried(
    wanted: Mapping[Target, Sequence[Mutant]],
    *,
    record: Path = KEPT,
    jobs: int = os.cpu_count() or 1,
    trusts_kills: bool = False,
) -> list[Outcome]:
    """Try the mutants of each target and report the survivors; raises `TrialError`."""
    outcomes: list[Outcome] = []
    with open_fork_server() as server, tempfile.TemporaryDirectory(prefix="wax-mutants-") as folder:
        kept = Record(record, trusts_kills=trusts_kills)
        bench = Bench(server, kept, Path(folder), jobs=jobs)
        for target, mutants in wanted.items():
            print(f"{target.file} …", file=sys.stderr, flush=True)
            found = bench.try_all(target, mutants)
            for one in found:
                if one.outcome == SURVIVED:
                    print(f"  {one}", file=sys.stderr, flush=True)
            outcomes += found
    return outcomes


def main() -> int:
    arguments = _arguments()
    targets = [one for one in TARGETS if any(name in one.file for name in arguments.only)]
    start_s = time.monotonic()
    try:
        outcomes = tried(
            {target: mutants_of(target) for target in targets},
            record=arguments.record,
            jobs=arguments.jobs,
            trusts_kills=arguments.trust_kills,
        )
    except TrialError as error:
        print(f"wax: {error}", file=sys.stderr)
        return 2
    print(f"{to_table(outcomes)}\n{(time.monotonic() - start_s) / 60:.1f} min")
    return _judge(outcomes)


def _judge(outcomes: list[Outcome]) -> int:
    """Print what is missing; return the exit status."""
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
        prog="python -m tests.mutants",
        description="Put small faults into what keeps the robot standing; the tests must notice.",
    )
    parser.add_argument(
        "--only", nargs="+", metavar="PART", help="files with this in their path", default=[""]
    )
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, metavar="N")
    parser.add_argument("--record", type=Path, default=KEPT, metavar="FILE", help="kept there")
    parser.add_argument(
        "--trust-kills", action="store_true", help="after tests were added: the survivors only"
    )
    arguments = parser.parse_args()
    for name in arguments.only:
        if not any(name in one.file for one in TARGETS):
            parser.error(f"no file has {name} in its path; they are in {_PLAN}")
    return arguments


if __name__ == "__main__":
    sys.exit(main())
