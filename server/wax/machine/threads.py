"""Checks whether this user may start as many threads as WAX needs.

Otherwise each library fails in its own way: OpenBLAS interrupts the process, asyncio cannot even
close.
"""

from __future__ import annotations

import threading
from typing import Final

from wax.errors import StartError

SERVERS: Final = 32
"""Half of these run once robot, camera and microphone do; the other half is for viewers."""
DOCTORS: Final = 12
ADVICE: Final = (
    "Raise the limit: `TasksMax=` or `LimitNPROC=` in the unit of systemd, `--pids-limit` of a"
    " container, `ulimit -u` in a shell. Docker before 20.10.10 allows newer systems"
    " none: update it."
)


def problem(needed: int) -> str:
    """Start `needed` threads at once; return why that fails, empty if it does not."""
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
    """Raise `StartError` if `needed` threads cannot be started."""
    why = problem(needed)
    if why:
        raise StartError(f"{why} {ADVICE}")
