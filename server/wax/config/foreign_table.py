"""Validates the table of a foreign driver in a process of its own.

That loads the driver's class, which may do anything while it loads: print, hang, end the process. A
class that cannot be loaded is not refused here: building the driver reports why.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from typing import TYPE_CHECKING, Any, Final

from wax.config import driver_tables
from wax.machine import python_module

if TYPE_CHECKING:
    from collections.abc import Collection

_LOAD_S: Final = 20.0


def check(robot: dict[str, Any], ours: Collection[str]) -> list[str]:
    """Return the sentences of `driver_tables.check_here`; empty if the class cannot be loaded."""
    asked = json.dumps({"robot": robot, "ours": sorted(ours)}, default=str)
    try:
        done = python_module.ask("wax.config.foreign_table", asked.encode(), _LOAD_S)
        lines = json.loads(done.stdout)
    except (OSError, subprocess.TimeoutExpired, ValueError):
        return []
    return [str(line) for line in lines]


def main() -> None:
    """Check the table on standard input; what the class prints goes to standard error."""
    asked = json.load(sys.stdin.buffer)
    writer = os.dup(1)
    os.dup2(2, 1)
    lines = driver_tables.check_here(asked["robot"], ours=asked["ours"])
    os.write(writer, json.dumps(lines).encode())
    os._exit(0)  # a thread that the class left behind must not keep the process alive


if __name__ == "__main__":
    main()
