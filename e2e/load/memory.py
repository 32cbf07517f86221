"""Memory: with one viewer, for each further one, and after many have joined and left."""

from __future__ import annotations

import asyncio
import statistics
from typing import TYPE_CHECKING, Final

from e2e.load.crowd.crowd import gathered
from e2e.load.servers import SIDES, STOCK, WAX, serving
from e2e.measure.row import Row, judged

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.load.crowd.crowd import Crowd
    from e2e.load.servers import MeasuredServer

VIEWERS: Final = {WAX: (1, 16), STOCK: (1, 4)}
ONE_MIB: Final = 250.0
FURTHER_MIB: Final = 0.5
FLAT_MIB: Final = 2.0
"""Growth over all joins and leaves that still counts as flat: the allocator's own variation."""
BATCHES: Final = 5
_SETTLE_S: Final = {WAX: 10.0, STOCK: 4.0}
"""Viewers who join pass through smaller renditions. We keep the encoders of these for 5 s more, and
return freed memory within another 5 s."""
_FORGET_S: Final = 60.0
_LOOKS: Final = 5
_LOOK_EVERY_S: Final = 0.2


async def memory(n: int) -> list[Row]:
    """Hold more and more viewers, then let `n` join and leave, in batches.

    Stock does not report its asyncio tasks.
    """
    batch = max(1, n // BATCHES)
    found = {side: await _use(side, batch) for side in SIDES}

    def row(key: str, what: str, unit: str, goal: float, n: int = batch * BATCHES) -> Row:
        values = {side: use[key] for side, use in found.items()}
        return judged(f"memory: {key}", what, unit, values, goal, n=n)

    return [
        row("one", "memory with one viewer", "MiB", ONE_MIB, 1),
        row("further", "… for each further one", "MiB", FURTHER_MIB, VIEWERS[WAX][-1]),
        row("leaked", "… lost by viewers who join and leave", "MiB", FLAT_MIB),
        row("left", "threads, descriptors and tasks that they leave", "", 0.0),
    ]


async def _use(side: str, batch: int) -> dict[str, float]:
    """Return MiB resident, and how many threads, descriptors and tasks were left.

    Server and viewers share the cores: nothing here depends on speed.
    """
    async with serving(side) as server, gathered(server.offering) as crowd:
        held_mib = []
        for number in VIEWERS[side]:
            await crowd.hold(number)
            await asyncio.sleep(_SETTLE_S[side])
            held_mib.append(await _rss_mib(server))
        await crowd.hold(0)
        leaked, left = await come_and_go(server, crowd, batch)
    further = _slope(VIEWERS[side], held_mib)
    return {"one": held_mib[0], "further": further, "leaked": leaked, "left": left}


async def come_and_go(server: MeasuredServer, crowd: Crowd, batch: int) -> tuple[float, int]:
    """Let batches join and leave; return the MiB that they leak, and the handles they leave.

    The leak is the slope of the second half: allocator and libraries first fill pools that stay,
    while a leak continues.
    """
    after_mib, left = [], []
    for _ in range(BATCHES + 1):
        await crowd.cycle(batch)
        await is_empty(server)
        after_mib.append(await _rss_mib(server))
        left.append(await handles(server))
    half = BATCHES // 2
    a_batch_mib = _slope(range(half, BATCHES + 1), after_mib[half:])
    return a_batch_mib * BATCHES, left[-1] - left[0]


async def is_empty(server: MeasuredServer) -> None:
    """Wait until all viewers are forgotten; our server keeps a place for the grace time."""
    if server.side != STOCK:
        what = "viewers who left are forgotten"
        await server.until(lambda told: not told["viewers"], what, within_s=_FORGET_S)
    await asyncio.sleep(_SETTLE_S[server.side])


async def _rss_mib(server: MeasuredServer) -> float:
    readings = [server.meter.rss_mib()]
    for _ in range(4):
        await asyncio.sleep(0.1)
        readings.append(server.meter.rss_mib())
    return statistics.median(readings)


async def handles(server: MeasuredServer) -> int:
    """Count the server's threads, descriptors and tasks that stay, without those just closing."""
    found = []
    for _ in range(_LOOKS):
        await asyncio.sleep(_LOOK_EVERY_S)
        tasks = 0 if server.side == STOCK else int((await server.status())["tasks"])
        found.append(server.meter.handles() + tasks)
    return min(found)


def _slope(x: Sequence[int], y: Sequence[float]) -> float:
    return statistics.linear_regression(x, y).slope
