"""What server and browser cost while a cell is watched, and how busy the machine is."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Self

import psutil  # type: ignore[import-untyped]  # its stubs are not among the dev tools

from e2e.delay.results import Server
from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from e2e.browsers import Browser

_MIB = 1024 * 1024


class CostMeter:
    """Counts from its making on. Raises `MeasureError` when the process `pid` has ended."""

    def __init__(self, pid: int, name: str) -> None:
        self._pid = pid
        self._name = name
        self._from_s = time.monotonic()
        self._before_s, _ = self._read()

    def read(self) -> Server:
        """Return the share of one core since the beginning, and the memory now."""
        now_s, memory_bytes = self._read()
        share = max(0.0, now_s - self._before_s) / (time.monotonic() - self._from_s)
        return Server(cpu_share=share, memory_mib=memory_bytes / _MIB)

    def _read(self) -> tuple[float, int]:
        """Return processor time, s, and resident bytes of all of them."""
        try:
            process = psutil.Process(self._pid)
            children = process.children(recursive=True)
            cpu_s, memory_bytes = _costs(process)
        except psutil.NoSuchProcess as error:
            raise MeasureError(f"{self._name} has ended; its last words are in its log") from error
        for child in children:
            try:
                more_s, more_bytes = _costs(child)
            except psutil.NoSuchProcess:  # it had its time
                continue
            cpu_s, memory_bytes = cpu_s + more_s, memory_bytes + more_bytes
        return cpu_s, memory_bytes


class BrowserMeter:
    """What a browser's own processes cost, where it tells."""

    def __init__(self, browser: Browser, before_s: float | None) -> None:
        self._browser = browser
        self._before_s = before_s
        self._from_s = time.monotonic()

    @classmethod
    async def start(cls, browser: Browser) -> Self:
        return cls(browser, await browser.cpu_s())

    async def read(self) -> float | None:
        """Return the share of one core since the start; None where the browser tells nothing."""
        now_s = await self._browser.cpu_s()
        if now_s is None or self._before_s is None:
            return None
        return max(0.0, now_s - self._before_s) / (time.monotonic() - self._from_s)


class MachineMeter:
    """How busy the whole machine is from its making on, whoever uses it."""

    def __init__(self) -> None:
        psutil.cpu_percent()

    def read(self) -> float:
        """Return the share of all cores."""
        return float(psutil.cpu_percent()) / 100


def _costs(process: psutil.Process) -> tuple[float, int]:
    with process.oneshot():
        times = process.cpu_times()
        return times.user + times.system, process.memory_info().rss
