"""The priority of a process that tells the robot to move or to stand."""

from __future__ import annotations

import os
import time
from contextlib import suppress
from pathlib import Path
from typing import Final

NICENESS: Final = -10
_TRIES: Final = 3
_PAUSE_S: Final = 0.1


def raise_priority() -> None:
    """Let this process go before others, and its session where it leads one.

    Most users may not, unless `LimitNICE=` of systemd lets them; then the robot's own watchdog
    covers an overloaded machine.
    """
    with suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, 0, NICENESS)
    if os.getsid(0) != os.getpid():
        return
    # Outside control groups Linux weighs sessions first, and a process only within its own:
    # sched(7), "autogroup". Without CAP_SYS_ADMIN one such call per 0.1 s is taken of all.
    with suppress(OSError):
        for _ in range(_TRIES):
            with suppress(BlockingIOError):
                Path("/proc/self/autogroup").write_text(f"{NICENESS}", encoding="ascii")
                return
            time.sleep(_PAUSE_S)
