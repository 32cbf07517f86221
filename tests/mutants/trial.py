"""Tests the mutants of one source, several at once."""

from __future__ import annotations

import itertools
import os
import shutil
import time
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING, Final

from tests.mutants import cpp_build
from tests.mutants.fork_server import BROKEN, FAILED, PASSED, TIMED_OUT, use_source
from tests.mutants.record import KILLED, NEVER_ENDED, NONE, SURVIVED, evidence_of

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from tests.mutants.fork_server import ForkServer
    from tests.mutants.mutant import Mutant
    from tests.mutants.plan import Target
    from tests.mutants.record import Outcome, Record

_OUTCOMES: Final = {PASSED: SURVIVED, FAILED: KILLED, TIMED_OUT: NEVER_ENDED}
_LIBRARY: Final = "WAX_FIRMWARE_LIBRARY"


class TrialError(Exception):
    """The mutants cannot be tested; the text says why and shows the tests' output."""


@dataclass(frozen=True, slots=True)
class _Pending:
    mutant: Mutant
    start_s: float
    folder: Path


class Bench:
    """Tests mutants in `server`, `jobs` at once, which write to `folder`."""

    def __init__(self, server: ForkServer, record: Record, folder: Path, *, jobs: int) -> None:
        self._server = server
        self._record = record
        self._folder = folder
        self._jobs = jobs
        self._numbers = itertools.count()
        self._cpu_s: dict[tuple[str, ...], float] = {}

    def try_all(self, target: Target, mutants: Sequence[Mutant]) -> list[Outcome]:
        """Test the mutants that are not on record; raises `TrialError`."""
        evidence = evidence_of(target, self._server.tree)
        found = {one: self._record.find(one, evidence) for one in mutants}
        waiting = [one for one, outcome in reversed(found.items()) if outcome is None]
        running: dict[int, _Pending] = {}
        if waiting and target.tests not in self._cpu_s:
            self._cpu_s[target.tests] = self._without_a_fault(target)
        while waiting or running:
            while waiting and len(running) < self._jobs:
                pending = _Pending(waiting.pop(), time.monotonic(), self._room())
                running[self._start(target, pending.mutant.source, pending.folder)] = pending
            run, code, _ = self._server.wait()
            done = running.pop(run)
            took_s = time.monotonic() - done.start_s
            outcome = _outcome(code, done)
            found[done.mutant] = self._record.add(done.mutant, outcome, took_s, evidence)
            shutil.rmtree(done.folder)
        return [outcome for outcome in found.values() if outcome is not None]

    def _without_a_fault(self, target: Target) -> float:
        """Run the tests on the unchanged source; return their processor time."""
        source = (self._server.tree / target.file).read_text(encoding="utf-8")
        folder = self._room()
        self._start(target, source, folder, compare=False)
        _, code, cpu_s = self._server.wait()
        if code != PASSED:
            raise TrialError(
                f"the tests of {target.file} fail without a fault ({code}):\n{_said(folder)}"
            )
        return cpu_s

    def _start(self, target: Target, source: str, folder: Path, *, compare: bool = True) -> int:
        cpu_s = self._cpu_s.get(target.tests, 300.0)
        prepare = partial(use_source, target.module, source, self._server.tree)
        if target.is_cpp:
            prepare = partial(
                self._use_library, target.file, source, folder, self._whole if compare else None
            )
        return self._server.start(
            target.tests,
            prepare,
            cpu_s=5 + 3 * cpu_s,
            wall_s=20 + 10 * cpu_s,  # a machine that also has other work
            log=folder / "log",
        )

    def _use_library(self, file: str, source: str, folder: Path, whole: Path | None) -> None:
        built = cpp_build.build(self._server.tree, file, source, folder / "build", whole)
        os.environ[_LIBRARY] = str(built)

    @cached_property
    def _whole(self) -> Path:
        return cpp_build.build_whole(self._server.tree, self._folder / "whole")

    def _room(self) -> Path:
        folder = self._folder / str(next(self._numbers))
        folder.mkdir()
        return folder


def _outcome(code: int, done: _Pending) -> str:
    """Return the meaning of an exit code; raises `TrialError` if it is not the mutant's fault."""
    if code == BROKEN:
        raise TrialError(f"{done.mutant} could not be tested:\n{_said(done.folder)}")
    if code in _OUTCOMES:
        return _OUTCOMES[code]
    # A signal ended the tests. Any other code means that pytest reached no test, as after a failed
    # import: this is no program, as a compiler would say.
    return KILLED if code < 0 else NONE


def _said(folder: Path) -> str:
    return (folder / "log").read_text(encoding="utf-8", errors="replace")
