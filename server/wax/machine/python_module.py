"""A module of ours in a process of its own, which finds plug-ins where this one found them."""

from __future__ import annotations

import os
import subprocess
import sys


def command(module: str) -> list[str]:
    """Return what runs `module`; -P: not what lies in the working directory."""
    return [sys.executable, "-P", "-m", module]


def environment() -> dict[str, str]:
    """Return this process's environment, with the places where it looks for modules."""
    return os.environ | {"PYTHONPATH": os.pathsep.join(p or "." for p in sys.path)}


def ask(module: str, question: bytes, within_s: float) -> subprocess.CompletedProcess[bytes]:
    """Give it the question, and return what it answers until it ends.

    Raises `OSError` if it cannot be started, `subprocess.TimeoutExpired` if it takes longer.
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
