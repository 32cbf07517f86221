"""The priority of a process that tells the robot to move or to stand."""

from __future__ import annotations

import os
from contextlib import suppress
from typing import Final

NICENESS: Final = -10
REALTIME: Final = 1
"""The lowest of real time, which goes before all that is not."""


def raise_priority() -> None:
    """Let this thread and those it starts go before others, in real time where it may.

    Else by niceness, which is only a share: beside busy programs Linux lets a process that slept
    wait for tens of milliseconds now and then, more than the robot's own watchdog allows.
    Most users may do neither, unless `LimitRTPRIO=` and `LimitNICE=` of systemd let them; then the
    robot's own watchdog covers an overloaded machine.
    """
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(REALTIME))
    except (AttributeError, OSError):  # only Linux and the BSDs have it
        with suppress(AttributeError, OSError):
            os.setpriority(os.PRIO_PROCESS, 0, NICENESS)
