"""Runs a module of ours in a process of its own, with this one's module search path."""

from __future__ import annotations

import os
import subprocess
import sys


def command(module: str) -> list[str]:
    """Return the command that runs `module`; -P keeps the working directory off its path."""
    return [sys.executable, "-P", "-m", module]


def environment() -> dict[str, str]:
    """Return this process's environment, with its module search path."""
    return os.environ | {"PYTHONPATH": os.pathsep.join(p or "." for p in sys.path)}


def ask(module: str, question: bytes, within_s: float) -> subprocess.CompletedProcess[bytes]:
    """Run a module with `question` as its input, and return its exit status and output.

    Raises `OSError` if it cannot be started, `subprocess.TimeoutExpired` after `within_s`.
    """
    return subprocess.run(
        command(module),
        input=question,
        stdout=subprocess.PIPE,
        timeout=within_s,
        env=environment(),
        start_new_session=True,
        check=False,
    )
