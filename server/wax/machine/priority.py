"""The priority of a process that moves and stops the robot, and of work that can wait."""

from __future__ import annotations

import os
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterator

NICENESS: Final = -10
REALTIME: Final = 1
"""The lowest real-time priority, which precedes everything that is not real-time."""


def raise_priority() -> None:
    """Give this thread, and what it starts, real-time priority if the user may.

    Otherwise it gets a niceness, which is only a share: beside busy programs, Linux may let a
    process that wakes up wait for tens of milliseconds, more than the robot's own watchdog allows.
    Most users may set neither, unless systemd's `LimitRTPRIO=` and `LimitNICE=` permit it; then the
    robot's own watchdog covers an overloaded machine.
    """
    if _realtime_priority():
        return
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(REALTIME))
    except (AttributeError, OSError):  # macOS has none
        with suppress(AttributeError, OSError):
            os.setpriority(os.PRIO_PROCESS, 0, NICENESS)


def lower_priority() -> None:
    """Give this process only the time that nothing else wants.

    Even the lowest niceness, which is only a share, lets a server that wakes up wait for it.
    """
    os.nice(19)
    with suppress(AttributeError, OSError):  # macOS has none, a filter of system calls
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))


@contextmanager
def as_others() -> Iterator[None]:
    """Start processes in this block without real-time priority, until they raise their own.

    This thread, too, gives it up for the block. A higher priority than ours, given by the host, is
    left alone: this process might not get it back.
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
    """Return the real-time priority, 1 to 99; 0 without one."""
    try:
        return os.sched_getparam(0).sched_priority
    except (AttributeError, OSError):  # macOS has none, musl only the name
        return 0
