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
    if _realtime_priority():
        return
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(REALTIME))
    except (AttributeError, OSError):  # macOS has none
        with suppress(AttributeError, OSError):
            os.setpriority(os.PRIO_PROCESS, 0, NICENESS)


@contextmanager
def as_others() -> Iterator[None]:
    """Let a process that starts in this block compute outside real time, until it raises itself.

    This thread leaves it, too, for the block. What a host gave beyond ours is left as it is: it
    might not be given twice.
    """
    if _realtime_priority() != REALTIME:
        yield
        return
    with suppress(OSError):  # a filter of system calls
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    try:
        yield
    finally:
        raise_priority()


def _realtime_priority() -> int:
    """Return 1 to 99; outside real time 0."""
    try:
        return os.sched_getparam(0).sched_priority
    except (AttributeError, OSError):  # macOS has none, musl only the name
        return 0
