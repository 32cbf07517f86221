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
from typing import TYPE_CHECKING, NoReturn

if TYPE_CHECKING:
    from collections.abc import Callable

TIMED_OUT, NOT_FOUND = 124, 127  # as timeout(1) and the shell have them


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


def insist(
    limit_s: float,
    tries: int,
    command: list[str],
    *,
    sleep: Callable[[float], object] = time.sleep,
) -> int:
    """Try `command` until it succeeds; returns the status of the last try."""
    status = 0
    for number in range(1, tries + 1):
        try:
            status = attempt(command, limit_s)
        except OSError as error:
            print(f"wax: {command[0]} cannot be started: {error.strerror}", file=sys.stderr)
            return NOT_FOUND
        if status == 0 or number == tries:
            break
        why = f"not done after {limit_s:.0f} s" if status == TIMED_OUT else f"failed ({status})"
        print(f"wax: {' '.join(command[:5])} … {why}; trying again", file=sys.stderr)
        sleep(2 * number)
    return status if status >= 0 else 128 - status


def interrupted(signal_number: int, _frame: object) -> NoReturn:
    sys.exit(128 + signal_number)


if __name__ == "__main__":
    for wanted in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(wanted, interrupted)
    sys.exit(insist(float(sys.argv[1]), int(sys.argv[2]), sys.argv[3:]))
