"""Measures the chosen cases one after the other, and publishes each suite that is complete.

Each case runs in a process and a session of its own: if it crashes or hangs, no other is lost, and
it cannot be affected by another case's leftovers in memory.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from importlib import import_module
from typing import TYPE_CHECKING, Final

from e2e.measure import machine
from e2e.measure.command import NOT_RUN, chosen, origin_of, times
from e2e.measure.errors import MeasureError
from e2e.measure.headline import ROWS
from e2e.measure.published import publish
from e2e.measure.results import Results
from e2e.measure.suite import ROOT

if TYPE_CHECKING:
    import argparse
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from e2e.measure.results import Result
    from e2e.measure.suite import Case, Suite

SUITES: Final = {
    "delay": "e2e.delay.suite",
    "load": "e2e.load.suite",
    "stop": "e2e.stop.suite",
    "strangers": "e2e.strangers.suite",
    "safety-tests": "tests.mutants.suite",
}
"""Each suite's module, in the order of the tables."""

_WORST: Final = (130, 2, NOT_RUN, 1, 0)
"""Exit statuses: the first of these that occurs is the result."""
_HANGS_MINUTES: Final = 10.0
"""A case that takes three times its minutes, plus these, hangs."""
_TIDY_S: Final = 30.0


@dataclass(frozen=True, slots=True)
class Task:
    """One case to be measured `n` times, of the suite in `module`."""

    module: str
    suite: Suite
    case: Case
    n: int

    @property
    def minutes(self) -> float:
        return self.case.minutes_of(self.n)


def loaded(names: Sequence[str], suites: Mapping[str, str] = SUITES) -> dict[str, Suite]:
    """Import these suites, or all if none is named; return them by module."""
    return {module: import_module(module).SUITE for name, module in suites.items()
            if name in names or not names}  # fmt: skip


def planned(suites: Mapping[str, Suite], arguments: argparse.Namespace) -> list[Task]:
    """Return the chosen cases that have no result of this commit and machine yet.

    The README's come first, then the quick ones, so that a fault shows early. Uncommitted code is
    always measured again, because two states of it cannot be told apart.
    """
    modules = {suite.name: module for module, suite in suites.items()}
    tasks = [
        Task(modules[suite.name], suite, case, times(case, arguments))
        for suite, case in chosen(list(suites.values()), arguments.only, long=arguments.long)
    ]
    tasks.sort(
        key=lambda task: (not any(key.startswith(task.case.key) for key in ROWS), task.minutes)
    )
    if arguments.again or machine.commit().endswith("-dirty"):
        return tasks
    kept = {suite.name: _kept(suite, arguments.out) for suite in suites.values()}
    return [task for task in tasks if (task.case.key, task.n) not in kept[task.suite.name]]


def _kept(suite: Suite, out: Path) -> dict[tuple[str, int], Result]:
    found = Results(out / suite.name).of(origin_of(suite))
    return {key: result for key, result in found.items() if result.status == "ok"}


def measure(tasks: Sequence[Task], out: Path) -> int:
    """Measure; return the worst exit status. Raises `MeasureError` if the commit has changed."""
    began_on, statuses = machine.commit(), {0}
    for number, task in enumerate(tasks):
        if (now_on := machine.commit()) != began_on:
            raise MeasureError(
                f"this began on {began_on}, and the tree is {now_on} now; nothing is lost: go back "
                f"to {began_on} and give the same words, or begin again on {now_on}"
            )
        minutes = sum(one.minutes for one in tasks[number:])
        end = datetime.now(UTC).astimezone() + timedelta(minutes=minutes)
        print(
            f"{task.suite.name}: {task.case.key}, {number + 1} of {len(tasks)};"
            f" {minutes:.0f} min left, until {end:%H:%M}",
            file=sys.stderr,
            flush=True,
        )
        statuses.add(_in_own_process(task, out))
    return next(status for status in _WORST if status in statuses)


def _in_own_process(task: Task, out: Path) -> int:
    """Measure one case; raises `KeyboardInterrupt` when it is interrupted."""
    command = [sys.executable, "-m", "e2e.measure.command", task.module, "--long"]
    command += ["--only", task.case.key, "--n", str(task.n), "--out", str(out)]
    limit_s = 60 * (3 * task.minutes + _HANGS_MINUTES)
    # Its standard input closes when this process is gone, however it ended.
    with subprocess.Popen(
        command, cwd=ROOT, stdin=subprocess.PIPE, start_new_session=True
    ) as process:
        try:
            status = process.wait(limit_s)
        except subprocess.TimeoutExpired:
            print(f"{task.case.key}: no end after {limit_s / 60:.0f} min", file=sys.stderr)
            status = 2
        finally:
            _end(process)
    return status if status in _WORST else 2


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a case, which may clean up first, and whatever it has left running."""
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
        with suppress(subprocess.TimeoutExpired):
            process.wait(_TIDY_S)
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)


def publish_complete(suites: Sequence[Suite], out: Path, folder: Path) -> bool:
    """Write each suite whose cases all have a full result of this commit; return whether any has.

    If all suites are complete, the files of former suites are deleted.
    """
    complete = []
    for suite in suites:
        kept = _kept(suite, out)
        keys = [(case.key, case.n) for case in suite.cases if not case.long]
        if lacking := [key[0] for key in keys if key not in kept]:
            print(f"{suite.name} is not published, without {', '.join(lacking)}", file=sys.stderr)
        else:
            results = [kept[key] for key in keys]
            print(f"published: {publish(suite, results, folder)}", file=sys.stderr)
            complete.append(suite.name)
    if set(complete) >= set(SUITES):
        for path in folder.glob("*.json"):
            if path.stem not in SUITES:
                path.unlink()
    return bool(complete)
