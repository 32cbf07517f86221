"""Whether this user may run a process in real time, as root may outside a container."""

from __future__ import annotations

import subprocess
import sys

_ASK = "import os; os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))"


def may_run_in_real_time() -> bool:
    asked = subprocess.run([sys.executable, "-c", _ASK], check=False, stderr=subprocess.DEVNULL)
    return asked.returncode == 0
