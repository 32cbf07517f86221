"""The priority of a process: real time where it may, else niceness, else what it has."""

from __future__ import annotations

import os
from typing import Final

import pytest

from wax.machine.priority import NICENESS, REALTIME, as_others, raise_priority

pytestmark = pytest.mark.skipif(
    not hasattr(os, "sched_setscheduler"), reason="this system has no real time"
)

REAL_TIME: Final = (os.SCHED_RR, REALTIME)


class Kernel:
    """Grants what is in `grants`; `schedule` is a thread's policy and priority."""

    def __init__(self, *grants: str) -> None:
        self.grants = grants
        self.schedule = (os.SCHED_OTHER, 0)
        self.niceness = 0

    def sched_getscheduler(self, _: int) -> int:
        return self.schedule[0]

    def sched_getparam(self, _: int) -> os.sched_param:
        return os.sched_param(self.schedule[1])

    def sched_setscheduler(self, _: int, policy: int, param: os.sched_param) -> None:
        if "real time" not in self.grants:
            raise PermissionError
        self.schedule = policy, param.sched_priority

    def setpriority(self, _: int, __: int, niceness: int) -> None:
        if "niceness" not in self.grants:
            raise PermissionError
        self.niceness = niceness


@pytest.fixture
def kernel(monkeypatch: pytest.MonkeyPatch) -> Kernel:
    kernel = Kernel("real time", "niceness")
    for name in ("sched_getscheduler", "sched_getparam", "sched_setscheduler", "setpriority"):
        monkeypatch.setattr(os, name, getattr(kernel, name))
    return kernel


@pytest.mark.parametrize(
    ("grants", "schedule", "niceness"),
    [
        (["real time", "niceness"], REAL_TIME, 0),
        (["niceness"], (os.SCHED_OTHER, 0), NICENESS),
        ([], (os.SCHED_OTHER, 0), 0),
    ],
)
def test_it_takes_the_best_that_it_may(
    kernel: Kernel, grants: list[str], schedule: tuple[int, int], niceness: int
) -> None:
    kernel.grants = tuple(grants)
    raise_priority()
    assert (kernel.schedule, kernel.niceness) == (schedule, niceness)


def test_it_lowers_nobody(kernel: Kernel) -> None:
    """Whoever has been given more by the host keeps it."""
    kernel.schedule = (os.SCHED_FIFO, 50)
    raise_priority()
    assert kernel.schedule == (os.SCHED_FIFO, 50)


@pytest.mark.parametrize("schedule", [REAL_TIME, (os.SCHED_FIFO, 50), (os.SCHED_OTHER, 0)])
def test_what_it_starts_runs_as_others_do(kernel: Kernel, schedule: tuple[int, int]) -> None:
    kernel.schedule = schedule
    with as_others():
        assert kernel.schedule == (os.SCHED_OTHER, 0)
    assert kernel.schedule == schedule
