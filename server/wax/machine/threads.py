"""Whether this user may start as many threads as WAX takes.

Where they may not, each library ends in its own way: OpenBLAS interrupts the process, asyncio
cannot even close.
"""

from __future__ import annotations

import threading
from typing import Final

from wax.errors import StartError

SERVERS: Final = 32
"""Half of these run once the robot, the camera and the microphone do; the rest is for viewers."""
DOCTORS: Final = 12
ADVICE: Final = (
    "Raise the limit: `TasksMax=` or `LimitNPROC=` in the unit of systemd, `--pids-limit` of a"
    " container, `ulimit -u` in a shell. Docker before 20.10.10 allows newer systems"
    " none: update it."
)


def problem(needed: int) -> str:
    """Try to have so many at once; return what keeps them from it, empty if nothing does."""
    over = threading.Event()
    made: list[threading.Thread] = []
    try:
        for _ in range(needed):
            one = threading.Thread(target=over.wait)
            one.start()
            made.append(one)
    except RuntimeError:  # "can't start new thread": all that Python says
        return f"This user may start {len(made)} threads more, and WAX takes {needed}."
    finally:
        over.set()
        for one in made:
            one.join()
    return ""


def check(needed: int) -> None:
    """Raise `StartError` where they cannot be had."""
    why = problem(needed)
    if why:
        raise StartError(f"{why} {ADVICE}")
