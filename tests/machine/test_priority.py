"""The priority of a process: real-time if permitted, else niceness, else unchanged."""

from __future__ import annotations

import errno
import os
import subprocess
from contextlib import suppress
from typing import TYPE_CHECKING, Final

import pytest

from wax.clock import SystemClock
from wax.machine.priority import NICENESS, REALTIME, as_others, lower_priority, raise_priority
from wax.robot.gpio.guard import Guard
from wax.robot.ros2.settings import Ros2Settings
from wax.robot.ros2.standby_process import StandbyProcess

if TYPE_CHECKING:
    from collections.abc import Callable

pytestmark = pytest.mark.skipif(
    not hasattr(os, "sched_setscheduler"), reason="this system has no real time"
)

REAL_TIME: Final = (os.SCHED_RR, REALTIME)
OTHERS: Final = (os.SCHED_OTHER, 0)
NO_CALL: Final = (-1, 1)
"""The limits of a service whose filter of system calls allows neither."""


class Kernel:
    """A fake kernel of one thread, with limits for real-time priority and niceness."""

    def __init__(self, most: int, least: int) -> None:
        self.limits = (most, least)
        self.schedule = OTHERS
        self.niceness = 0

    def sched_getparam(self, _: int) -> os.sched_param:
        return os.sched_param(self.schedule[1])

    def sched_setscheduler(self, _: int, policy: int, param: os.sched_param) -> None:
        if param.sched_priority > self.limits[0]:
            raise PermissionError
        self.schedule = policy, param.sched_priority

    def setpriority(self, _: int, __: int, niceness: int) -> None:
        if niceness < self.limits[1]:
            raise PermissionError
        self.niceness = niceness

    def nice(self, more: int) -> int:
        self.niceness += more
        return self.niceness


@pytest.fixture
def kernel(monkeypatch: pytest.MonkeyPatch) -> Kernel:
    kernel = Kernel(REALTIME, NICENESS)
    for name in ("sched_getparam", "sched_setscheduler", "setpriority", "nice"):
        monkeypatch.setattr(os, name, getattr(kernel, name))
    return kernel


@pytest.mark.parametrize(
    ("limits", "schedule", "niceness"),
    [
        ((REALTIME, NICENESS), REAL_TIME, 0),
        ((0, NICENESS), OTHERS, NICENESS),
        ((0, 0), OTHERS, 0),
    ],
)
def test_it_takes_the_best_that_it_may(
    kernel: Kernel, limits: tuple[int, int], schedule: tuple[int, int], niceness: int
) -> None:
    kernel.limits = limits
    raise_priority()
    assert (kernel.schedule, kernel.niceness) == (schedule, niceness)


def test_it_lowers_nobody(kernel: Kernel) -> None:
    """A higher priority given by the host is kept, since it might not be regained."""
    kernel.schedule = (os.SCHED_FIFO, 50)
    raise_priority()
    with as_others():
        assert kernel.schedule == (os.SCHED_FIFO, 50)
    assert kernel.schedule == (os.SCHED_FIFO, 50)


@pytest.mark.parametrize(
    ("limits", "inside", "after"),
    [
        ((REALTIME, NICENESS), OTHERS, REAL_TIME),
        ((0, NICENESS), OTHERS, OTHERS),
        (NO_CALL, REAL_TIME, REAL_TIME),
    ],
)
def test_it_comes_back_to_the_best_that_it_may(
    kernel: Kernel, limits: tuple[int, int], inside: tuple[int, int], after: tuple[int, int]
) -> None:
    kernel.limits, kernel.schedule = limits, REAL_TIME
    with as_others():
        assert kernel.schedule == inside
    assert kernel.schedule == after


@pytest.mark.parametrize(("limits", "schedule"), [((0, 0), (os.SCHED_IDLE, 0)), (NO_CALL, OTHERS)])
def test_what_can_wait_gets_the_time_that_nothing_wants(
    kernel: Kernel, limits: tuple[int, int], schedule: tuple[int, int]
) -> None:
    kernel.limits = limits
    lower_priority()
    assert (kernel.schedule, kernel.niceness) == (schedule, 19)


def test_a_system_with_the_names_alone_is_no_error(
    kernel: Kernel, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuses(*_: object) -> None:
        raise OSError(errno.ENOSYS, "as musl says")

    for name in ("sched_getparam", "sched_setscheduler"):
        monkeypatch.setattr(os, name, refuses)
    with as_others():
        raise_priority()
    assert kernel.niceness == NICENESS


@pytest.mark.parametrize(
    "starts",
    [
        lambda: Guard([17]),
        lambda: StandbyProcess(Ros2Settings.model_validate({}), SystemClock()).poll(),
    ],
    ids=["guard", "standby"],
)
def test_what_stands_in_for_the_driver_loads_outside_real_time(
    kernel: Kernel, monkeypatch: pytest.MonkeyPatch, starts: Callable[[], object]
) -> None:
    def started(*_: object, **__: object) -> None:
        seen.append(kernel.schedule)
        raise OSError

    seen: list[tuple[int, int]] = []
    monkeypatch.setattr(subprocess, "Popen", started)
    kernel.schedule = REAL_TIME
    with suppress(OSError):
        starts()
    assert (seen, kernel.schedule) == ([OTHERS], REAL_TIME)
