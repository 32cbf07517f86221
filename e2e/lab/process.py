"""What a process and its children cost, while some of them may come and go."""

from __future__ import annotations

import time

import psutil  # type: ignore[import-untyped]  # its stubs are not among the dev tools

from e2e.lab.results import Server
from e2e.measure.errors import MeasureError

_MIB = 1024 * 1024


class CostMeter:
    """Counts from its making on. Raises `MeasureError` when the process `pid` has ended."""

    def __init__(self, pid: int, name: str) -> None:
        self._name = name
        try:
            self._process = psutil.Process(pid)
        except psutil.NoSuchProcess as error:
            raise MeasureError(f"{name} has ended; its last words are in the run's log") from error
        self._from_s = time.monotonic()
        self._before_s = self._cpu_s()

    def read(self) -> Server:
        """Return the share of one core since the beginning, and the memory now."""
        used_s = self._cpu_s() - self._before_s
        memory = sum(found for _, found in self._family())
        return Server(
            cpu_share=max(0.0, used_s) / (time.monotonic() - self._from_s),
            memory_mib=memory / _MIB,
        )

    def _cpu_s(self) -> float:
        return sum(used for used, _ in self._family())

    def _family(self) -> list[tuple[float, int]]:
        """Return processor time, s, and resident bytes of each."""
        try:
            children = self._process.children(recursive=True)
            costs = [_costs(self._process)]
        except psutil.NoSuchProcess as error:
            raise MeasureError(
                f"{self._name} ended while it was watched; its last words are in the run's log"
            ) from error
        for child in children:
            try:
                costs.append(_costs(child))
            except psutil.NoSuchProcess:  # it had its time
                continue
        return costs


class MachineMeter:
    """How busy the whole machine is from its making on, whoever uses it."""

    def __init__(self) -> None:
        self._before = psutil.cpu_times()

    def read(self) -> float:
        """Return the share of all cores."""
        now = psutil.cpu_times()
        spent = [
            getattr(now, name) - getattr(self._before, name)
            for name in now._fields
            if not name.startswith("guest")  # it is part of the user's
        ]
        idle = now.idle - self._before.idle
        idle += getattr(now, "iowait", 0.0) - getattr(self._before, "iowait", 0.0)
        return 1 - idle / sum(spent) if sum(spent) > 0 else 0.0


def _costs(process: psutil.Process) -> tuple[float, int]:
    with process.oneshot():
        times = process.cpu_times()
        return times.user + times.system, process.memory_info().rss
