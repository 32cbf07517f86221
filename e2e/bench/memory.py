"""Memory: with one viewer, for each further one, and after many have come and gone."""

from __future__ import annotations

import statistics
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

from e2e.bench.errors import BenchError
from e2e.bench.servers import Server
from e2e.crowd import Crowd

if TYPE_CHECKING:
    from e2e.bench.plan import Plan
    from e2e.bench.process import Handles, Memory
    from e2e.bench.servers import Side

BATCHES = 10
FORGET_TIMEOUT_S = 15.0


@dataclass(frozen=True, slots=True)
class MemoryPoint:
    """Median of several readings with so many viewers."""

    viewers: int
    rss_mib: float
    uss_mib: float
    rss_spread_mib: float


@dataclass(frozen=True, slots=True)
class Churn:
    """`cycles` joins and leaves, in batches; a reading after each, when nobody is here any more.

    The slope is that of the second half: allocator and libraries first fill pools that stay, and
    what leaks goes on leaking. `tasks` are asyncio tasks
    by the server's own account; stock gives none.
    """

    cycles: int
    rss_before_mib: float
    rss_after_mib: float
    rss_after_each_batch_mib: list[float]
    rss_kib_per_cycle: float
    handles_before: Handles
    handles_after: Handles
    tasks_before: int | None
    tasks_after: int | None


@dataclass(frozen=True, slots=True)
class MemoryUse:
    """One side."""

    points: list[MemoryPoint]
    rss_mib_per_further_viewer: float
    uss_mib_per_further_viewer: float
    churn: Churn


def measure(side: Side, plan: Plan) -> MemoryUse:
    """Server and viewers share the cores: nothing here depends on speed."""
    numbers = plan.our_memory_viewers if side == "ours" else plan.stock_memory_viewers
    points = []
    with Server(side) as server, Crowd(server.offering) as crowd:
        for number in numbers:
            crowd.hold(number)
            time.sleep(plan.memory_settle_s)
            points.append(_point(server, number))
        crowd.hold(0)
        churn = _churn(server, crowd, plan)
    viewers = [point.viewers for point in points]
    return MemoryUse(
        points=points,
        rss_mib_per_further_viewer=_slope(viewers, [point.rss_mib for point in points]),
        uss_mib_per_further_viewer=_slope(viewers, [point.uss_mib for point in points]),
        churn=churn,
    )


def _point(server: Server, viewers: int) -> MemoryPoint:
    readings = _readings(server)
    rss = [reading.rss_mib for reading in readings]
    return MemoryPoint(
        viewers=viewers,
        rss_mib=statistics.median(rss),
        uss_mib=statistics.median(reading.uss_mib for reading in readings),
        rss_spread_mib=max(rss) - min(rss),
    )


def _churn(server: Server, crowd: Crowd, plan: Plan) -> Churn:
    batch = max(1, plan.cycles // BATCHES)
    crowd.cycle(batch)
    _wait_empty(server, plan)
    before, tasks_before = server.meter.handles(), _tasks(server)
    rss_mib = [_rss_mib(server)]
    for _ in range(BATCHES):
        crowd.cycle(batch)
        _wait_empty(server, plan)
        rss_mib.append(_rss_mib(server))
    cycles = [batch * index for index in range(BATCHES + 1)]
    half = BATCHES // 2
    return Churn(
        cycles=batch * BATCHES,
        rss_before_mib=rss_mib[0],
        rss_after_mib=rss_mib[-1],
        rss_after_each_batch_mib=rss_mib[1:],
        rss_kib_per_cycle=1024 * _slope(cycles[half:], rss_mib[half:]),
        handles_before=before,
        handles_after=server.meter.handles(),
        tasks_before=tasks_before,
        tasks_after=_tasks(server),
    )


def _wait_empty(server: Server, plan: Plan) -> None:
    """Wait until the server has forgotten everybody; ours keeps a place for its time of grace."""
    deadline_s = time.monotonic() + FORGET_TIMEOUT_S
    while server.side == "ours" and server.status()["viewers"]:
        if time.monotonic() > deadline_s:
            raise BenchError(f"viewers who left are still listed after {FORGET_TIMEOUT_S:g} s")
        time.sleep(0.1)
    time.sleep(plan.memory_settle_s / 4)


def _readings(server: Server) -> list[Memory]:
    readings = []
    for _ in range(5):
        readings.append(server.meter.memory())
        time.sleep(0.1)
    return readings


def _rss_mib(server: Server) -> float:
    return statistics.median(reading.rss_mib for reading in _readings(server))


def _tasks(server: Server) -> int | None:
    if server.side == "stock":
        return None
    return int(server.status()["tasks"])


def _slope(x: list[int], y: list[float]) -> float:
    return statistics.linear_regression(x, y).slope
