"""The priority of a process: real time where it may, else niceness, else what it has."""

from __future__ import annotations

import os

import pytest

from wax.machine.priority import NICENESS, REALTIME, raise_priority


class Kernel:
    """Grants what is in `grants` and remembers it."""

    def __init__(self, *grants: str) -> None:
        self.grants = grants
        self.granted: list[tuple[object, ...]] = []

    def sched_setscheduler(self, pid: int, policy: int, param: os.sched_param) -> None:
        self._asked("real time", pid, policy, param.sched_priority)

    def setpriority(self, *how: int) -> None:
        self._asked("niceness", *how)

    def _asked(self, what: str, *how: int) -> None:
        if what not in self.grants:
            raise PermissionError
        self.granted.append((what, *how))


@pytest.mark.parametrize(
    ("grants", "granted"),
    [
        (["real time", "niceness"], [("real time", 0, os.SCHED_RR, REALTIME)]),
        (["niceness"], [("niceness", os.PRIO_PROCESS, 0, NICENESS)]),
        ([], []),
    ],
)
def test_it_takes_the_best_that_it_may(
    grants: list[str], granted: list[tuple[object, ...]], monkeypatch: pytest.MonkeyPatch
) -> None:
    kernel = Kernel(*grants)
    for name in ("sched_setscheduler", "setpriority"):
        monkeypatch.setattr(os, name, getattr(kernel, name))
    raise_priority()
    assert kernel.granted == granted
