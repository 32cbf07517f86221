"""Run a command that talks to a package mirror: bounded in time, tried again when it fails.

usage: patiently.py LIMIT_S TRIES COMMAND…

Written in Python because macOS has no `timeout`. The exit status is the command's.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from typing import NoReturn

TIMED_OUT = 124  # as timeout(1) has it


def attempt(command: list[str], limit_s: float) -> int:
    """Run `command` once in a process group of its own, which does not outlive this call."""
    with subprocess.Popen(command, start_new_session=True) as process:
        try:
            return process.wait(limit_s)
        except subprocess.TimeoutExpired:
            return TIMED_OUT
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)


def interrupted(signal_number: int, _frame: object) -> NoReturn:
    sys.exit(128 + signal_number)


def main(limit_s: float, tries: int, command: list[str]) -> int:
    for wanted in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(wanted, interrupted)
    status = attempt(command, limit_s)
    for wait_s in range(2, 2 * tries, 2):
        if status == 0:
            break
        why = f"not done after {limit_s:.0f} s" if status == TIMED_OUT else f"failed ({status})"
        print(f"wax: {' '.join(command[:5])} … {why}; trying again", file=sys.stderr)
        time.sleep(wait_s)
        status = attempt(command, limit_s)
    return status if status >= 0 else 128 - status


if __name__ == "__main__":
    sys.exit(main(float(sys.argv[1]), int(sys.argv[2]), sys.argv[3:]))
