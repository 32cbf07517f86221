"""Detects a process that uses ever more of the machine, before others run short."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Final

MAX_BYTES: Final = 2 << 30
"""Known drivers need a fraction of this; a machine-learning camera may need more."""
MAX_THREADS: Final = 500
"""Far above any thread pool, far below a user's limit."""


class ResourceUse:
    """What a process may use: up to half of the machine's memory, and no more than the above."""

    def __init__(self, max_bytes: int | None = None, max_threads: int = MAX_THREADS) -> None:
        self._max_bytes = _share() if max_bytes is None else max_bytes
        self._max_threads = max_threads

    def excess(self, pid: int) -> str | None:
        """Return the excessive use, such as ``3072 MB``; None if there is none or it is unknown."""
        if sys.platform != "linux":
            return None
        try:
            status = Path(f"/proc/{pid}/status").read_text(encoding="ascii", errors="replace")
        except OSError:
            return None
        values = dict(line.split(":", 1) for line in status.splitlines() if ":" in line)
        used = 1024 * _number(values.get("VmRSS", ""))
        threads = _number(values.get("Threads", ""))
        if used > self._max_bytes:
            return f"{used >> 20} MB"
        return f"{threads} threads" if threads > self._max_threads else None


def _number(text: str) -> int:
    first = text.split()[:1]
    return int(first[0]) if first and first[0].isdecimal() else 0


def _share() -> int:
    try:
        installed = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (ValueError, OSError):
        return MAX_BYTES
    return min(MAX_BYTES, installed // 2)
