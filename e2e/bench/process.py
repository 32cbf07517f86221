"""What a process costs: processor time, memory, threads and descriptors; and on which core."""

from __future__ import annotations

import os
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import psutil  # type: ignore[import-untyped]  # its stubs are not among the dev tools

if TYPE_CHECKING:
    from collections.abc import Iterator

MIB = 1024 * 1024


@dataclass(frozen=True, slots=True)
class Memory:
    """Resident, and what would be freed if the process ended; MiB."""

    rss_mib: float
    uss_mib: float


@dataclass(frozen=True, slots=True)
class Handles:
    """What a leak leaves behind."""

    threads: int
    descriptors: int


class ProcessMeter:
    """Reads the costs of one process and of its children; all at `pid` must be alive."""

    def __init__(self, pid: int) -> None:
        self._process = psutil.Process(pid)

    def cpu_s(self) -> float:
        """Processor time used so far, user and system, seconds."""
        total = 0.0
        for process in self._family():
            times = process.cpu_times()
            total += times.user + times.system
        return total

    def memory(self) -> Memory:
        infos = [process.memory_full_info() for process in self._family()]
        return Memory(
            rss_mib=sum(info.rss for info in infos) / MIB,
            uss_mib=sum(info.uss for info in infos) / MIB,
        )

    def handles(self) -> Handles:
        return Handles(
            threads=sum(process.num_threads() for process in self._family()),
            descriptors=sum(process.num_fds() for process in self._family()),
        )

    def _family(self) -> list[psutil.Process]:
        return [self._process, *self._process.children(recursive=True)]


class CoreMeter:
    """How busy one core is, whoever uses it; None stands for the whole machine."""

    def __init__(self, core: int | None) -> None:
        self._core = core

    def busy_s(self) -> float:
        """Seconds so far in which the core did not idle."""
        if self._core is None:
            times = psutil.cpu_times()
        else:
            times = psutil.cpu_times(percpu=True)[self._core]
        idle = times.idle + getattr(times, "iowait", 0.0)
        # On Linux guest time is already part of user time.
        guest = getattr(times, "guest", 0.0) + getattr(times, "guest_nice", 0.0)
        return float(sum(times) - idle - guest)


def two_cores() -> tuple[int, int] | None:
    """Choose a core for the server and one for the receivers; None where that cannot be had."""
    if not hasattr(os, "sched_getaffinity"):
        return None
    allowed = sorted(os.sched_getaffinity(0))
    return (allowed[0], allowed[1]) if len(allowed) > 1 else None


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


def machine_memory_mib() -> int:
    """Count the memory of the whole machine."""
    return int(psutil.virtual_memory().total // MIB)


def udp_receive_errors() -> int | None:
    """Count datagrams that the kernel threw away for want of room; None where it does not tell."""
    try:
        text = Path("/proc/net/snmp").read_text(encoding="ascii")
    except OSError:
        return None
    rows = [line.split() for line in text.splitlines() if line.startswith("Udp:")]
    return int(dict(zip(rows[0], rows[1], strict=True))["RcvbufErrors"])
