"""The suite about the tests of the code that stops the robot: mutants, and branches."""

from __future__ import annotations

import json
import random
import subprocess
from typing import Final

from e2e.measure import machine
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, judged
from e2e.measure.suite import Case, Suite
from tests.mutants import branches, survivors
from tests.mutants.__main__ import mutants_of, tried
from tests.mutants.plan import ACCEPTED, ROOT, TARGETS
from tests.mutants.record import KILLED, NEVER_ENDED, NONE, SURVIVED
from tests.mutants.trial import TrialError

_DRAWN: Final = 600
_ALL: Final = 1_000_000


def mutants(n: int) -> list[Row]:
    """Draw `n` mutants, others at each commit; survivors must be listed with their reason."""
    every = [(target, mutant) for target in TARGETS for mutant in mutants_of(target)]
    drawn = random.Random(machine.commit()).sample(every, min(n, len(every)))
    wanted = {
        target: [mutant for its, mutant in drawn if its is target]
        for target in dict.fromkeys(target for target, _ in drawn)
    }
    try:
        outcomes = tried(wanted)
    except TrialError as error:
        raise MeasureError(str(error)) from error
    noticed = sum(one.outcome in {KILLED, NEVER_ENDED} for one in outcomes)
    faults = sum(one.outcome != NONE for one in outcomes)
    survived = [one for one in outcomes if one.outcome == SURVIVED]
    unlisted = survivors.unlisted(survived, survivors.read())
    what = "small faults in what keeps the robot standing that the tests notice"
    row = _share("mutants", what, noticed, faults, 100 * ACCEPTED)
    return [row.model_copy(update={"detail": {"survived without a reason": unlisted}})]


def taken(_: int) -> list[Row]:
    """Count the branches that the tests take, in each language."""
    python, cpp = branches.counted()
    page = _of_the_page()
    return [
        _share("branches: Python", "branches of it that the tests take, in Python", *python, 100.0),
        _share("branches: C++", "… in C++", *cpp, 100.0),
        _share("branches: page", "… of what lets go in the page", *page, 100.0),
    ]


def _of_the_page() -> tuple[int, int]:
    done = subprocess.run(
        ["npm", "run", "--silent", "--prefix", "web", "coverage"], cwd=ROOT, check=False
    )
    summary = ROOT / ".cache/coverage/coverage-summary.json"
    if done.returncode not in (0, 1) or not summary.exists():
        raise MeasureError("the page's branches were not counted; its words are above")
    found = json.loads(summary.read_text(encoding="utf-8"))["total"]["branches"]
    return found["covered"], found["total"]


def _share(key: str, what: str, part: int, of: int, goal: float) -> Row:
    share = {"share": 100 * part / of}
    return judged(key, what, "%", share, goal, n=of, at_least=True, column="share")


SUITE: Final = Suite(
    name="safety-tests",
    about="The tests themselves: small faults that they must notice, and branches that they take.",
    measures=(
        *sorted({target.file for target in TARGETS}),
        *sorted({test.partition("::")[0] for target in TARGETS for test in target.tests}),
        *("web/src/drive/**/*.ts", "web/src/drive/**/*.tsx"),
    ),
    columns=("share",),
    cases=(
        Case("branches", "count of all", 1, taken, minutes=1.5),
        Case("mutants", "drawn of five thousand changes", _DRAWN, mutants, 30, minutes=4),
        Case("mutants-all", "all changes", _ALL, mutants, 30, minutes=25, long=True),
    ),
)
