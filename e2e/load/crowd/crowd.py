"""Starts and controls a crowd on this machine."""

from __future__ import annotations

import contextlib
import select
import subprocess
import sys
from typing import TYPE_CHECKING, Final, Self

import psutil  # type: ignore[import-untyped]  # its stubs are not among the dev tools

from e2e.load.crowd.sample import Request, Sample
from e2e.load.process import ProcessMeter, pinned
from e2e.measure.errors import MeasureError
from e2e.measure.suite import ROOT

if TYPE_CHECKING:
    from collections.abc import Callable

    from e2e.load.crowd.sample import Offering

ANSWER_TIMEOUT_S: Final = 180.0
LEAVE_TIMEOUT_S: Final = 10.0
_NICE: Final = 10


class Crowd:
    """`with Crowd(offering, core) as crowd: crowd.hold(8); crowd.count()`.

    The first `slow` of them are behind a modem each. `through` makes its command line the one that
    runs it elsewhere. On its core the crowd yields to whoever
    measures. Every request raises `MeasureError` if the crowd's process could not carry it out.
    """

    def __init__(
        self,
        offering: Offering,
        core: int | None = None,
        *,
        slow: int = 0,
        through: Callable[[list[str]], list[str]] = list,
    ) -> None:
        words = ["-m", "e2e.load.crowd", offering.url, offering.how, str(slow)]
        with pinned(core):
            self._process = subprocess.Popen(
                through([sys.executable, *words]),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                cwd=ROOT,
            )
        self.meter = ProcessMeter(self._process.pid)
        psutil.Process(self._process.pid).nice(_NICE)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        with self._process:
            assert self._process.stdin is not None
            self._process.stdin.close()
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(LEAVE_TIMEOUT_S)
            self._process.kill()

    def hold(self, number: int) -> None:
        """Return when exactly `number` viewers see and hear."""
        self._ask(Request(verb="hold", number=number))

    def cycle(self, number: int) -> None:
        """Let `number` viewers join and leave once they receive picture and sound."""
        self._ask(Request(verb="cycle", number=number))

    def count(self) -> Sample:
        return self._ask(Request(verb="count"))

    def _ask(self, request: Request) -> Sample:
        to, back = self._process.stdin, self._process.stdout
        assert to is not None
        assert back is not None
        try:
            to.write(request.model_dump_json().encode() + b"\n")
            to.flush()
        except OSError as error:
            raise MeasureError(f"the viewers' process ended before {request.verb}") from error
        if not select.select([back], [], [], ANSWER_TIMEOUT_S)[0]:
            raise MeasureError(f"the viewers did not {request.verb} in {ANSWER_TIMEOUT_S:g} s")
        if not (line := back.readline()):
            raise MeasureError(f"the viewers' process ended while asked to {request.verb}")
        sample = Sample.model_validate_json(line)
        if sample.problem is not None:
            raise MeasureError(sample.problem)
        return sample
