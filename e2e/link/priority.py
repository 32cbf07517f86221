"""To be served before the programs under test, whose work would else pass for the network's."""

from __future__ import annotations

import os


def be_first() -> bool:
    """Run this process in real time where that is allowed, which is as root; say whether it is.

    A better niceness would not do: each session is a scheduling group of its own (sched(7)).
    """
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))
    except PermissionError:
        return False
    return True
