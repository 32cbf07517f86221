"""A process's cost in processor time, memory, threads and descriptors, and its core."""

from __future__ import annotations

import asyncio
import os
import time
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import psutil

from e2e.measure.errors import MeasureError, NotRunError

if TYPE_CHECKING:
    from collections.abc import Iterator

MIB = 1024 * 1024


class ProcessMeter:
    """Reads the costs of one process and of its children; the process at `pid` must be alive."""

    def __init__(self, pid: int) -> None:
        self._process = psutil.Process(pid)

    def cpu_s(self) -> float:
        """Processor time used so far, user and system, seconds."""
        times = [process.cpu_times() for process in self._family()]
        return float(sum(one.user + one.system for one in times))

    async def share(self, seconds: float) -> float:
        """Wait this long; return the processor time used meanwhile, in seconds per second."""
        began_s, used_s = time.monotonic(), self.cpu_s()
        await asyncio.sleep(seconds)
        return (self.cpu_s() - used_s) / (time.monotonic() - began_s)

    def rss_mib(self) -> float:
        return float(sum(process.memory_info().rss for process in self._family()) / MIB)

    def handles(self) -> int:
        """Count threads and descriptors: what a leak leaves behind."""
        return sum(process.num_threads() + process.num_fds() for process in self._family())

    def _family(self) -> list[psutil.Process]:
        return [self._process, *self._process.children(recursive=True)]


def two_cores() -> tuple[int, int]:
    """Choose a core for the server and one for everything else; raises `NotRunError`."""
    allowed = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else []
    if len(allowed) < 2:
        raise NotRunError("this needs two cores and a way to pin processes to them (Linux)")
    return allowed[0], allowed[1]


@contextmanager
def pinned(core: int | None) -> Iterator[None]:
    """Keep processes that are started inside this block on `core`; None changes nothing."""
    if core is None:
        yield
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {core})
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


def udp_receive_errors() -> int:
    """Count datagrams that Linux dropped for want of buffer space (``RcvbufErrors``, RFC 4113)."""
    text = Path("/proc/net/snmp").read_text(encoding="ascii")
    names, values = (line.split() for line in text.splitlines() if line.startswith("Udp:"))
    return int(dict(zip(names, values, strict=True))["RcvbufErrors"])


@contextmanager
def all_received() -> Iterator[None]:
    """Raise `MeasureError` if the kernel dropped datagrams in this block."""
    before = udp_receive_errors()
    yield
    if (thrown := udp_receive_errors() - before) > 0:
        raise MeasureError(f"the kernel threw away {thrown} datagrams before they were read")
