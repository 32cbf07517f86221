"""The priority of a process: real time where it may, else niceness, else what it has."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from wax.machine.priority import NICENESS, REALTIME, raise_priority, start_as_others


class Kernel:
    """Grants what is in `grants` and remembers it."""

    def __init__(self, *grants: str) -> None:
        self.grants = grants
        self.granted: set[tuple[object, ...]] = set()

    def sched_setscheduler(self, pid: int, policy: int, param: os.sched_param) -> None:
        self._asked("real time", pid, policy, param.sched_priority)

    def setpriority(self, *how: int) -> None:
        self._asked("niceness", *how)

    def _asked(self, what: str, *how: int) -> None:
        if what not in self.grants:
            raise PermissionError
        self.granted.add(how)


def asked(monkeypatch: pytest.MonkeyPatch, *grants: str) -> Kernel:
    kernel = Kernel(*grants)
    for name in ("sched_setscheduler", "setpriority"):
        monkeypatch.setattr(os, name, getattr(kernel, name))
    return kernel


def test_all_its_threads_run_in_real_time_where_they_may(monkeypatch: pytest.MonkeyPatch) -> None:
    kernel = asked(monkeypatch, "real time", "niceness")
    threads = [int(thread.name) for thread in Path("/proc/self/task").iterdir()]
    raise_priority()
    assert kernel.granted == {(thread, os.SCHED_RR, REALTIME) for thread in threads}


@pytest.mark.parametrize("grants", [["niceness"], []])
def test_else_it_takes_what_it_may(grants: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    kernel = asked(monkeypatch, *grants)
    raise_priority()
    assert kernel.granted == ({(os.PRIO_PROCESS, 0, NICENESS)} if grants else set())


def test_what_it_starts_does_not_load_in_real_time(monkeypatch: pytest.MonkeyPatch) -> None:
    kernel = asked(monkeypatch, "real time")
    start_as_others(7)
    assert kernel.granted == {(7, os.SCHED_OTHER, 0)}
