"""The priority of a process that tells the robot to move or to stand."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import Final

NICENESS: Final = -10
REALTIME: Final = 1
"""The lowest of real time, which goes before all that is not."""


def raise_priority() -> None:
    """Let this process go before others, in real time where it may, and so what it starts.

    Else by niceness, which is only a share: beside busy programs Linux lets a process that slept
    wait for tens of milliseconds now and then, more than the robot's own watchdog allows.
    Most users may do neither, unless `LimitRTPRIO=` and `LimitNICE=` of systemd let them; then the
    robot's own watchdog covers an overloaded machine.
    """
    try:
        for thread in Path("/proc/self/task").iterdir():
            with suppress(ProcessLookupError):
                os.sched_setscheduler(int(thread.name), os.SCHED_RR, os.sched_param(REALTIME))
    except OSError:  # it may not, or this is no Linux
        with suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, 0, NICENESS)


def start_as_others(pid: int) -> None:
    """Take real time from a process just started, until it raises itself: to load costs a core."""
    with suppress(AttributeError, OSError):
        os.sched_setscheduler(pid, os.SCHED_OTHER, os.sched_param(0))
