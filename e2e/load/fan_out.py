"""Fan-out: the cost of each further viewer for the server's core."""

from __future__ import annotations

import asyncio
import statistics
import sys
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from e2e.load.crowd.crowd import gathered
from e2e.load.process import two_cores, udp_receive_errors
from e2e.load.servers import JANUS, STOCK, WAX, MeasuredServer, serving, serving_janus
from e2e.measure.errors import MeasureError, NotRunError
from e2e.measure.row import Row, judged

if TYPE_CHECKING:
    from collections.abc import Sequence
    from contextlib import AbstractAsyncContextManager

    from e2e.load.crowd.crowd import Crowd
    from e2e.load.crowd.sample import Sample
    from e2e.load.servers import JanusServer

VIEWERS: Final = {WAX: (1, 16, 32, 50), STOCK: (1, 3, 6), JANUS: (1, 25, 50)}
"""Stock's core is full with eight."""
WINDOW_S: Final = 2.0
FPS: Final = 30.0
_SETTLE_S: Final = 4.0
_GROW_S: Final = 30.0
"""Longest wait until each viewer's congestion control allows the full picture."""
_SATURATED_CPU: Final = 0.90
_LEAST_FPS_SHARE: Final = 0.95


@dataclass(frozen=True, slots=True)
class Point:
    """One number of viewers.

    `cpu` is seconds of processor time per second, `cpu_sd` its spread. Saturated points are left
    out of the slope, and so are those with a `flaw`: something other than the server that limited
    them.
    """

    viewers: int
    cpu: float
    cpu_sd: float
    fps_min: float
    dropped: int
    saturated: bool
    flaw: str | None


async def fan_out(n: int) -> list[Row]:
    """Measure `n` windows for each number of viewers, server and viewers on a core each."""
    cores = two_cores()
    found = {side: await _points(side, n, *cores) for side in VIEWERS}
    slopes = {side: slope(points) for side, points in found.items()}
    most = next((one for one in found[WAX] if one.viewers == VIEWERS[WAX][-1]), None)
    return [
        judged(
            "fan-out: slope",
            "one viewer more (≤ 0.5 %, and ≤ 1/25 of stock’s)",
            "% of a core",
            slopes,
            (stock := slopes[STOCK]) and min(0.5, stock / 25),
            n=n,
            detail={side: [str(one) for one in points] for side, points in found.items()},
        ),
        judged(
            "fan-out: dropped",
            "packets dropped with 50 viewers on one core",
            "",
            {WAX: None if most is None else float(most.dropped)},
            None if most and most.flaw else 0.0,
            n=n,
        ),
    ]


async def _points(side: str, n: int, server_core: int, viewers_core: int) -> list[Point]:
    """Add viewers until there are enough or the server takes no more; none if it is missing."""
    serve: AbstractAsyncContextManager[MeasuredServer | JanusServer] = (
        serving_janus(server_core, viewers_core) if side == JANUS else serving(side, server_core)
    )
    points: list[Point] = []
    try:
        async with serve as server, gathered(server.offering, viewers_core) as crowd:
            for number in VIEWERS[side]:
                await crowd.hold(number)
                await grown(crowd)
                await asyncio.sleep(_SETTLE_S)
                points.append(await _point(server, crowd, n))
    except MeasureError as error:
        if not points and not isinstance(error, NotRunError):
            raise
        print(f"{side}, after {len(points)} numbers of viewers: {error}", file=sys.stderr)
    return points


async def grown(crowd: Crowd) -> None:
    """Wait until each viewer gets nearly every picture; if that never comes, the point says so."""
    deadline_s = time.monotonic() + _GROW_S
    before = await crowd.count()
    while time.monotonic() < deadline_s:
        await asyncio.sleep(1.0)
        now = await crowd.count()
        if received(before, now)[0] >= _LEAST_FPS_SHARE * FPS:
            return
        before = now


async def _point(server: MeasuredServer | JanusServer, crowd: Crowd, n: int) -> Point:
    errors, dropped = udp_receive_errors(), await _dropped(server)
    viewers_s = crowd.meter.cpu_s()
    first = await crowd.count()
    windows = [await server.meter.share(WINDOW_S) for _ in range(n)]
    last = await crowd.count()
    measured_s = last.at_s - first.at_s
    cpu = statistics.fmean(windows)
    viewers_cpu = (crowd.meter.cpu_s() - viewers_s) / measured_s
    fps_min, lost = received(first, last)
    saturated = cpu > _SATURATED_CPU or fps_min < _LEAST_FPS_SHARE * FPS
    flaw = None
    if viewers_cpu > _SATURATED_CPU:
        flaw = f"the viewers needed {viewers_cpu:.2f} of their core"
    elif (thrown := udp_receive_errors() - errors) > 0:
        flaw = f"the kernel threw away {thrown} datagrams before they were read"
    return Point(
        viewers=len(last.viewers),
        cpu=cpu,
        cpu_sd=statistics.stdev(windows) if n > 1 else 0.0,
        fps_min=fps_min,
        dropped=lost + await _dropped(server) - dropped,
        saturated=saturated,
        flaw=flaw,
    )


async def _dropped(server: MeasuredServer | JanusServer) -> int:
    """Return how much our server itself has dropped; the others do not report it."""
    if not isinstance(server, MeasuredServer) or server.side != WAX:
        return 0
    streams = (await server.status())["streams"]
    return sum(int(streams[kind]["dropped"]) for kind in ("video", "audio"))


def received(first: Sample, last: Sample) -> tuple[float, int]:
    """Return the lowest picture rate of any viewer, and the losses of all."""
    span_s = last.at_s - first.at_s
    pairs = list(zip(first.viewers, last.viewers, strict=True))
    fps = [(new.video.frames - old.video.frames) / span_s for old, new in pairs]
    lost = sum(
        getattr(new, kind).lost - getattr(old, kind).lost
        for old, new in pairs
        for kind in ("video", "audio")
    )
    return min(fps), lost


def slope(points: Sequence[Point]) -> float | None:
    """Fit least squares to the undisturbed points, in percent; None if they are too few."""
    good = [point for point in points if point.flaw is None and not point.saturated]
    if len(good) < 2:
        return None
    viewers, cpu = [point.viewers for point in good], [point.cpu * 100 for point in good]
    return statistics.linear_regression(viewers, cpu).slope
