"""``python -m tests.mutants``: what is noticed, file by file, and what is not.

`--publish` also counts the branches, and writes e2e/published/mutants.json.

Exit status: 0 when enough is noticed and every survivor is listed with its reason; 1 when not;
2 when the tests fail without any fault.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Final

from e2e.measure import machine
from e2e.measure.published import FOLDER, Published
from e2e.measure.row import Row, judged
from e2e.measure.suite import digest
from tests.mutants import branches, cpp_faults, python_faults, survivors
from tests.mutants.fork_server import open_fork_server
from tests.mutants.plan import ACCEPTED, ROOT, TARGETS
from tests.mutants.record import KILLED, NEVER_ENDED, NONE, SURVIVED, Record, to_table
from tests.mutants.trial import Bench, TrialError

if TYPE_CHECKING:
    from tests.mutants.mutant import Mutant
    from tests.mutants.plan import Target
    from tests.mutants.record import Outcome

_MEASURES: Final = (
    *sorted({target.file for target in TARGETS}),
    *sorted({test.partition("::")[0] for target in TARGETS for test in target.tests}),
)
_PLAN: Final = "tests/mutants/plan.py"
_KEPT: Final = ROOT / "e2e/out/mutants.jsonl"


def mutants_of(target: Target, tree: Path) -> list[Mutant]:
    source = (tree / target.file).read_text(encoding="utf-8")
    faults = cpp_faults.faults if target.is_cpp else python_faults.faults
    return faults(target.file, source)


def main() -> int:
    arguments = _arguments()
    targets = [one for one in TARGETS if any(name in one.file for name in arguments.only)]
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
    status = _judge(outcomes)
    if arguments.publish:
        _publish(outcomes)
    return status


def _publish(outcomes: list[Outcome]) -> None:
    noticed = sum(one.outcome in {KILLED, NEVER_ENDED} for one in outcomes)
    faults = sum(one.outcome != NONE for one in outcomes)
    python, cpp = branches.counted()
    safe = "what keeps the robot standing"
    rows = [
        _share("mutants", f"small faults in {safe} that the tests notice", noticed, faults, 95.0),
        _share(
            "branches: Python",
            "branches of it that the tests take, in Python",
            *python,
            100.0,
        ),
        _share("branches: C++", "… in C++", *cpp, 100.0),
    ]
    published = Published(
        suite="mutants",
        commit=machine.commit(),
        date=f"{datetime.now(UTC):%Y-%m-%d}",
        machine=str(machine.describe()),
        load=None,
        measures=list(_MEASURES),
        measured=digest(_MEASURES),
        columns=["share"],
        rows=rows,
    )
    (FOLDER / "mutants.json").write_text(published.to_json(), encoding="utf-8")


def _share(key: str, what: str, part: int, of: int, goal: float) -> Row:
    share = {"share": 100 * part / of}
    return judged(key, what, "%", share, goal, n=of, at_least=True, column="share")


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
        prog="python -m tests.mutants",
        description="Put small faults into what keeps the robot standing; the tests must notice.",
    )
    parser.add_argument(
        "--only", nargs="+", metavar="PART", help="files with this in their path", default=[""]
    )
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, metavar="N")
    parser.add_argument("--record", type=Path, default=_KEPT, metavar="FILE", help="kept there")
    parser.add_argument(
        "--trust-kills", action="store_true", help="after tests were added: the survivors only"
    )
    parser.add_argument("--publish", action="store_true", help="for the published table")
    arguments = parser.parse_args()
    for name in arguments.only:
        if not any(name in one.file for one in TARGETS):
            parser.error(f"no file has {name} in its path; they are in {_PLAN}")
    if arguments.publish and (arguments.only != [""] or machine.commit().endswith("-dirty")):
        parser.error("only a whole run on what is committed is published")
    return arguments


if __name__ == "__main__":
    sys.exit(main())
