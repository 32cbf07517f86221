"""The priority of a process that tells the robot to move or to stand."""

from __future__ import annotations

import os
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator

NICENESS: Final = -10
REALTIME: Final = 1
"""The lowest of real time, which goes before all that is not."""


def raise_priority() -> None:
    """Let this thread, and what it starts, go before others: in real time where it may.

    Else by niceness, which is only a share: beside busy programs Linux lets a process that slept
    wait for tens of milliseconds now and then, more than the robot's own watchdog allows.
    Most users may do neither, unless `LimitRTPRIO=` and `LimitNICE=` of systemd let them; then the
    robot's own watchdog covers an overloaded machine.
    """
    if _is_in_real_time():
        return
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(REALTIME))
    except (AttributeError, OSError):  # macOS has none
        with suppress(AttributeError, OSError):
            os.setpriority(os.PRIO_PROCESS, 0, NICENESS)


@contextmanager
def as_others() -> Iterator[None]:
    """Let what starts in this block run as others do, until it raises itself: it may compute."""
    if not _is_in_real_time():
        yield
        return
    policy, param = os.sched_getscheduler(0), os.sched_getparam(0)
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    try:
        yield
    finally:
        os.sched_setscheduler(0, policy, param)


def _is_in_real_time() -> bool:
    is_told = hasattr(os, "sched_getscheduler")
    return is_told and os.sched_getscheduler(0) in (os.SCHED_FIFO, os.SCHED_RR)
